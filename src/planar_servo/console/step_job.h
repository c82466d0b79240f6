#pragma once

#include <string>

#include "planar_servo/console/arm_jobs.h"

namespace planar {

/// Begins what is next of the work on a cell, as `planar next` names it, where that only reads and
/// writes files, from the plan to the found arm; returns the number of its job. `board` is the
/// calibration board, as --grid takes it. Throws InputError where nothing is left, or a person must
/// do it otherwise, and as the functions of CellJobs do.
int begin_step(ConsoleJobs& jobs, const std::string& board, StopsKnown known);

/// Begins or continues planar-experiment on a copy of this virtual cell in the folder `name` beside
/// the cell file, and returns as begin_step() does. Throws InputError for a real cell.
int begin_experiment(ConsoleJobs& jobs, const std::string& name, StopsKnown known);

}  // namespace planar
