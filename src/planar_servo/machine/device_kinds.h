#pragma once

#include <filesystem>

#include "planar_servo/cell/cell_settings.h"

namespace planar {

/// Returns the kinds of cameras, drives and trackers that this version can open. A new kind is a
/// folder of its own (see CONTRIBUTING.md) and a line in the list behind this function.
const DeviceKinds& device_kinds();

/// Reads a cell file that may ask for any of device_kinds(). Throws InputError naming every fault
/// with FILE:LINE:COLUMN.
CellSettings read_cell(const std::filesystem::path& path);

}  // namespace planar
