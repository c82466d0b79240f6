#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "planar_servo/files/cell_file.h"
#include "planar_servo/files/tables/plan_table.h"
#include "planar_servo/files/tables/target_table.h"

namespace planar {

/// Points of a circle, equally spaced, the first on the +x side.
std::vector<Eigen::Vector2d> circle_points(const Eigen::Vector2d& center, double radius, int count);

/// The paper's 100 control targets: 25 on each of four circles of radius 200 mm; ids c1_00 ...
/// c4_24.
std::vector<TargetRow> control_targets();

/// What the ids of the targets on control circle 1, 2, 3 or 4 begin with.
std::string control_id_prefix(int circle);

/// Centres of the four control circles, in the paper's order.
std::vector<Eigen::Vector2d> control_centers();

/// Everything that the experiment records before it closes the loop: board views, sweeps of joints
/// 1 and 3, 200 training and 30 test positions drawn from `seed` over the workspace, 24 check
/// points on each of the radii 150, 250 and 350 mm (ids r150_00 ...), and the four circles of the
/// paper's Figures 7 to 11 three times (ids run1_r100_00 ...).
std::vector<PlanRow> experiment_plan(const CellSettings& cell, std::uint64_t seed);

}  // namespace planar
