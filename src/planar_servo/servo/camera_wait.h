#pragma once

#include <string>

#include "planar_servo/core/clock.h"
#include "planar_servo/devices/frame_source.h"
#include "planar_servo/robot/planar_robot.h"

namespace planar {

/// The longest wait for a camera that fails.
constexpr double kCameraPatience_s = 60.0;

/// Waits, while the arm stands, until the camera's frames come as they should, and says so in the
/// log. `id` names what is to be continued, `reason` what is wrong. Returns false once the clock
/// is past `deadline_s`. Throws what PlanarRobot::throw_if_stopped() throws.
bool wait_for_camera(const FrameSource& camera, const PlanarRobot& robot, Clock& clock,
                     const std::string& id, const std::string& reason, double deadline_s);

}  // namespace planar
