#pragma once

#include <vector>

#include "files/cell_file.h"
#include "files/tables.h"

namespace planar {

/// True for rows that ask for a view of the calibration board.
bool is_board_view(const PlanRow& row);

/// The joint angles of every row of a plan (home for board views): the cell's elbow, the branch
/// within the joint limits that lies nearest to the row before. Throws InputError naming every
/// position that the arm cannot or must not take.
std::vector<Joints> joints_of_plan(const CellSettings& cell, const std::vector<PlanRow>& plan);

}  // namespace planar
