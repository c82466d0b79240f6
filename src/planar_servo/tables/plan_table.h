#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/core/plan.h"
#include "planar_servo/core/pose.h"

namespace planar {

/// Holds a row of plan.csv: one position to be recorded, by tip pose or by joints. Rows of the
/// plans "grid" and "plane_grid" ask for a view of the calibration board and need neither. Lengths
/// are in metres, angles in radians.
struct PlanRow {
  std::string id;
  Plan plan{Plan::kTrain};
  std::variant<std::monostate, TipPose, Joints> where;
};

/// Reads plan.csv. Rows by x and y that name no phi_deg take `tool_orientation` (radians). Throws
/// InputError naming FILE:LINE of each bad row, and for a table without rows.
std::vector<PlanRow> read_plan(const std::filesystem::path& path, double tool_orientation);
std::string plan_text(const std::vector<PlanRow>& rows);

}  // namespace planar
