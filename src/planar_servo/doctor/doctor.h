#pragma once

#include <filesystem>
#include <vector>

#include "planar_servo/cell/finding.h"

namespace planar {

/// Examines all of a cell that can be looked at without moving or switching on anything: its file,
/// its drives, its camera and its tracker, each by its kind. It questions values that can hardly be
/// meant. Throws InputError for a file with faults, and for devices that do not go together.
std::vector<Finding> examine_cell(const std::filesystem::path& cell_file);

}  // namespace planar
