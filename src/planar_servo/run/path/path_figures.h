#pragma once

#include <vector>

#include "planar_servo/files/path/path_run_tables.h"

namespace planar {

/// Returns the figures of these looks at one speed: errors and number, and nothing else.
PathSpeedResult path_figures(const std::vector<PathLookRow>& looks);

}  // namespace planar
