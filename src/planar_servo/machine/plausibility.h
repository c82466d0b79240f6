#pragma once

#include <vector>

#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/hardware/cell/device_kinds.h"

namespace planar {

/// Questions values of a cell file that are valid but hardly meant: lengths and angles in another
/// unit, or too large for each other, and discs that keep nothing out. No findings where all is
/// plausible.
std::vector<Finding> question_values(const CellSettings& cell);

/// Shows these questions in the log.
void warn_of_values(const CellSettings& cell);

}  // namespace planar
