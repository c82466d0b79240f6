#pragma once

#include <filesystem>
#include <string>

#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

/// Reads a cell file strictly. The devices that it asks for must be of `kinds`. Throws InputError
/// naming every fault with FILE:LINE:COLUMN.
CellSettings read_cell(const std::filesystem::path& path, const DeviceKinds& kinds);

/// Returns the block `servo` of a cell file in one line, such as "law: jacobian, gain: 1, ...".
std::string servo_text(const ServoSettings& servo);

}  // namespace planar
