#pragma once

#include <filesystem>
#include <vector>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

/// Reads saved pictures as frames of the camera. Throws InputError for one of another size.
std::vector<Frame> saved_frames(const std::vector<std::filesystem::path>& images,
                                const CellSettings& cell);

}  // namespace planar
