#pragma once

#include <string>
#include <vector>

#include "planar_servo/io/columns.h"

namespace planar {

/// The plans that rows of frames.csv and plan.csv may belong to.
const std::vector<std::string>& plan_names();

// The plans of views of the calibration board: held into the view, and laid on the plane.
constexpr char kHeldBoardPlan[] = "grid";
constexpr char kLaidBoardPlan[] = "plane_grid";

/// True of a plan whose rows show the calibration board instead of the lamps.
bool shows_board(const std::string& plan);

/// The column `plan`; reading, another name than those is a fault of the row.
void list_plan(Columns& columns, std::string& plan);

}  // namespace planar
