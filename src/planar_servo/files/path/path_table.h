#pragma once

#include <filesystem>

#include "planar_servo/servo/path/path.h"

namespace planar {

/// Reads path.csv, whose rows are the places that a path goes through, in the base frame: x_mm,
/// y_mm; a row with via_x_mm, via_y_mm is reached on the arc through that place, any other
/// straight; phi_deg is the tool's direction, by default `tool_orientation` (radians). Throws
/// InputError naming FILE:LINE of each row that cannot be reached from the one before it, and for
/// fewer than two rows.
Path read_path(const std::filesystem::path& file, double tool_orientation);

}  // namespace planar
