#pragma once

#include <vector>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/files/tables/plan_table.h"

namespace planar {

/// Returns the joint angles (radians) of every row of a plan; board views stand at home. Positions
/// are reached with the cell's elbow, on the branch within the joint limits that lies nearest to
/// the row before. Throws InputError naming every position that the arm cannot or must not take.
std::vector<Joints> joints_of_plan(const CellSettings& cell, const std::vector<PlanRow>& plan);

}  // namespace planar
