#pragma once

#include <filesystem>
#include <vector>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

/// Returns a whole picture of the cell's camera as a frame. Throws InputError naming `where` for
/// one of another size.
Frame whole_frame(const cv::Mat& image, const CellSettings& cell, const std::string& where);

/// Reads saved pictures as frames of the camera. Throws InputError for one of another size.
std::vector<Frame> saved_frames(const std::vector<std::filesystem::path>& images,
                                const CellSettings& cell);

}  // namespace planar
