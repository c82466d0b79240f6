#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/purpose.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/loop/vision/reference_lamps.h"

namespace planar {

/// Holds one row of lamps.csv: what was found in one image, in pixels of the whole sensor and, with
/// a workplane, in the base frame.
struct LampRow {
  std::string id;
  std::string image;
  std::optional<double> t_s;
  LampStatus status{LampStatus::kNoLamp};
  /// One lamp when a single disc is followed, two for a pair; none when nothing was found.
  std::vector<Eigen::Vector2d> uv_px;
  std::vector<Eigen::Matrix2d> covariance_px2;  ///< by the frame's noise; of the same size as uv_px
  std::optional<Eigen::Matrix2d> common_px2;    ///< of the shift of the image that all lamps share
  std::vector<LampLook> looks;                  ///< of the same size as uv_px, or empty
  std::optional<Eigen::Vector2d> p_vision;      ///< end point, metres
  std::optional<double> phi;                    ///< radians
  std::optional<Eigen::Vector2d> sigma;         ///< standard deviation of p_vision, metres
  std::optional<double> sigma_phi;              ///< of phi, radians; not in the table
};

/// Returns both lamps of a row that has two.
Observation observation_of(const LampRow& row);

std::vector<LampRow> read_lamps(const std::filesystem::path& path);
/// `remarks` are comment lines; see csv_remarks().
std::string lamps_text(const std::vector<LampRow>& rows,
                       const std::vector<std::string>& remarks = {});

/// Returns the comment lines of lamps.csv: what it was made from, and these lamps, which are fixed
/// to the base, since its pixels are as they were when they were seen there.
std::vector<std::string> lamp_remarks(const std::vector<Origin>& origins,
                                      const std::vector<ReferenceLamp>& lamps);

/// Returns the lamps of such lines at the top of a table; none when it has none.
std::vector<ReferenceLamp> read_reference_remarks(const std::filesystem::path& path);

// The input of a calibration's fits. Each table is read by a function that throws InputError naming
// FILE:LINE of each bad row, and for a table without rows. Texts begin with `remarks`, comment
// lines; see csv_remarks().

/// Holds a row of pairs.csv: the end point in the base frame as vision saw it and as the tracker
/// saw it. An unattended pose has no tracker reading. Lengths are in metres, angles in radians.
struct PairRow {
  std::string id;
  Eigen::Vector2d p_vision{0.0, 0.0};
  std::optional<Eigen::Vector2d> p_tracker{};
  std::optional<double> phi{};
  std::optional<double> sigma_vision{};
  std::optional<double> sigma_tracker{};
  std::optional<Purpose> plan{};  ///< none when the table does not say
  std::string place{};            ///< rows of one place share its name; empty when not given
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

/// Reads pairs.csv or, as pairs without lamps and joints, the valid places of a table of errors
/// over the plane; see ErrorGridRow.
std::vector<PairRow> read_pairs(const std::filesystem::path& path);
/// Passes each row on as it is read, so that a long table is never held whole. Errors are thrown at
/// its end.
void read_pairs(const std::filesystem::path& path, const std::function<void(const PairRow&)>& take);
std::string pairs_text(const std::vector<PairRow>& rows,
                       const std::vector<std::string>& remarks = {});

/// Holds a row of lays.csv: a dot of a calibration board that was laid on the plane. Rows of one
/// lay share its name; a turn and a shift, different for each lay, take p_board to where the dot
/// is. Lengths are in metres.
struct LayRow {
  std::string lay;
  /// On the board as seen from above, x along the rows; with a pitch of 1 mm where it is not known.
  Eigen::Vector2d p_board{0.0, 0.0};
  Eigen::Vector2d p_seen{0.0, 0.0};  ///< base frame, uncompensated
  double sigma{0.0};                 ///< of p_seen per axis
  bool pitch_known{true};
};

std::vector<LayRow> read_lays(const std::filesystem::path& path);
std::string lays_text(const std::vector<LayRow>& rows,
                      const std::vector<std::string>& remarks = {});

/// Holds a row of samples.csv: commanded joints and where a point of the tool was measured, base
/// frame.
struct ArmSampleRow {
  std::string id;
  Joints theta{0.0, 0.0, 0.0};    ///< radians
  Eigen::Vector2d p_B{0.0, 0.0};  ///< metres
  double sigma{0.0};              ///< per axis, metres
};

std::vector<ArmSampleRow> read_arm_samples(const std::filesystem::path& path);

}  // namespace planar
