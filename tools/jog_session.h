#pragma once

#include <filesystem>

#include "planar_servo/hardware/cell/cell_settings.h"
#include "program.h"

namespace planar {

/// Opens a cell and moves it by hand: executes the commands on standard input, one a line, and
/// prints their answers, until the lines end or one says `quit`. At a terminal it lists the
/// commands first, Enter stops an arm that moves, and refused commands are no failure. Without one
/// the first that fails is the last. Places are taught into the table `teach`, if there is one.
Outcome jog_by_lines(const CellSettings& cell, const std::filesystem::path& teach);

}  // namespace planar
