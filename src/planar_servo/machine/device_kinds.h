#pragma once

#include <filesystem>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/virtual_cell/virtual_hardware.h"

namespace planar {

/// Returns the kinds of cameras, drives and trackers that this version can open. CONTRIBUTING.md
/// says how to add a kind; it has a line in the list behind this function.
const DeviceKinds& device_kinds();

/// Reads a cell file that may name any of device_kinds(). Throws InputError naming every fault with
/// FILE:LINE:COLUMN.
CellSettings read_cell(const std::filesystem::path& path);

/// Returns the hardware that a virtual cell with these settings is made of, unless its truth knows
/// better.
VirtualHardware virtual_hardware(const CellSettings& cell);

}  // namespace planar
