#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/core/plan.h"

namespace planar {

/// Holds a row of pairs.csv: the end point in the base frame as vision saw it and as the tracker
/// saw it. An unattended pose has no tracker's word. Lengths are in metres, angles in radians.
struct PairRow {
  std::string id;
  Eigen::Vector2d p_vision{0.0, 0.0};
  std::optional<Eigen::Vector2d> p_tracker{};
  std::optional<double> phi{};
  std::optional<double> sigma_vision{};
  std::optional<double> sigma_tracker{};
  std::optional<Plan> plan{};  ///< none when the table does not say
  std::string place{};         ///< rows of one place share the word; empty when not said
  /// Where lamps 1 and 2 are seen on the plane, base frame, uncompensated.
  std::optional<std::array<Eigen::Vector2d, 2>> lamps_B{};
  std::optional<Eigen::Vector2d> p_reflector{};  ///< base frame
  std::optional<double> z_reflector{};           ///< base frame
  std::optional<Joints> theta{};                 ///< commanded
  std::optional<double> t_s{};                   ///< when it was seen

  bool is_attended() const { return p_tracker.has_value(); }
  /// Returns vision minus tracker. Throws std::bad_optional_access for an unattended pose.
  Eigen::Vector2d error() const { return p_vision - p_tracker.value(); }
};

/// Reads pairs.csv. Throws InputError naming FILE:LINE of each bad row, and for a table without
/// rows.
std::vector<PairRow> read_pairs(const std::filesystem::path& path);
/// Reads pairs.csv and hands each row on as it is read, so that a long table is never held whole.
/// The errors are thrown at its end.
void read_pairs(const std::filesystem::path& path, const std::function<void(const PairRow&)>& take);
/// `remarks` are comment lines; see csv_remarks().
std::string pairs_text(const std::vector<PairRow>& rows,
                       const std::vector<std::string>& remarks = {});

}  // namespace planar
