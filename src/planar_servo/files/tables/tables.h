#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/core/pose.h"

namespace planar {

// One struct per row of the tables that programs exchange; SI inside. Every reader throws
// InputError naming FILE:LINE of each bad row, and for a table without rows.

/// pairs.csv: the end point in the base frame as vision saw it and as the tracker saw it.
struct PairRow {
  std::string id;
  Eigen::Vector2d p_vision{0.0, 0.0};
  Eigen::Vector2d p_tracker{0.0, 0.0};
  std::optional<double> phi;
  std::optional<double> sigma_vision;
  std::optional<double> sigma_tracker;
  std::string plan;  ///< empty when the table has no such column

  Eigen::Vector2d error() const { return p_vision - p_tracker; }
};

std::vector<PairRow> read_pairs(const std::filesystem::path& path);
/// Hands each row on as it is read, so that a long table is never held whole; throws at its end.
void read_pairs(const std::filesystem::path& path, const std::function<void(const PairRow&)>& take);
std::string pairs_text(const std::vector<PairRow>& rows);

/// plan.csv: one position to be recorded, by tip pose or by joints; rows of the plans "grid" and
/// "plane_grid" ask for a view of the calibration board and have neither.
struct PlanRow {
  std::string id;
  std::string plan;
  std::variant<std::monostate, TipPose, Joints> where;
};

/// Rows by x and y that name no phi_deg take `tool_orientation` (radians).
std::vector<PlanRow> read_plan(const std::filesystem::path& path, double tool_orientation);
std::string plan_text(const std::vector<PlanRow>& rows);

}  // namespace planar
