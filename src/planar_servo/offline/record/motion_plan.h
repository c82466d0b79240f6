#pragma once

#include <vector>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/files/cell_file.h"
#include "planar_servo/files/tables/plan_table.h"

namespace planar {

/// Plans the cell's arm within its limits and workspace, with its elbow.
JointPlanner joint_planner(const CellSettings& cell);

/// The joint angles of every row of a plan (home for board views): the cell's elbow, the branch
/// within the joint limits that lies nearest to the row before. Throws InputError naming every
/// position that the arm cannot or must not take.
std::vector<Joints> joints_of_plan(const CellSettings& cell, const std::vector<PlanRow>& plan);

}  // namespace planar
