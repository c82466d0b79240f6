#pragma once

#include <memory>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/hardware/cameras/aravis_settings.h"

namespace planar {

/// Opens a GigE Vision or USB3 Vision camera through Aravis. One thread makes every call to the
/// camera and keeps frames coming, by software triggers if need be, so that a dead camera shows at
/// once. A lost camera is opened again, with growing pauses, and its settings are applied anew; no
/// other takes its place. Incomplete and repeated frames are counted and never handed over.
///
/// The region moves while frames stream. Another size restarts the stream and waits for its first
/// frame. The frames' region may be larger than asked for, by the raster of the camera. A
/// free-running or hardware-triggered exposure is dated by the camera's clock (CameraClock): due
/// arrival less exposure time. A new exposure waits until the camera has taken it, or is lost, and
/// may not take longer than the frame period.
///
/// Throws WorkError when the camera does not answer or refuses a setting, and InputError for
/// settings that no camera can have.
std::unique_ptr<FrameSource> open_aravis_camera(const AravisSettings& settings);

}  // namespace planar
