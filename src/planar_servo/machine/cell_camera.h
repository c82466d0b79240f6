#pragma once

#include <memory>

#include "planar_servo/devices/frame_source.h"
#include "planar_servo/files/cell_file.h"

namespace planar {

struct AravisSettings;

/// What the camera of a cell whose source is aravis is set to.
AravisSettings aravis_settings(const CellSettings& cell);

/// Opens the camera of a cell whose source is aravis. Throws WorkError when it does not answer or
/// refuses a setting, InputError for settings that no camera can have.
std::unique_ptr<FrameSource> open_camera(const CellSettings& cell);

}  // namespace planar
