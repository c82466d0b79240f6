#include "planar_servo/servo/camera_wait.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace planar {
namespace {

constexpr double kCameraPoll_s = 0.05;

}  // namespace

bool wait_for_camera(const FrameSource& camera, const PlanarRobot& robot, Clock& clock,
                     const std::string& id, const std::string& reason, double deadline_s) {
  const double lost_s = clock.now_s();
  spdlog::warn(fmt::format("{}: {}; the arm stands and waits", id, reason));
  while (camera.fault()) {
    if (clock.now_s() > deadline_s) return false;
    robot.throw_if_stopped();
    clock.sleep_for_s(kCameraPoll_s);
  }
  if (clock.now_s() > deadline_s) return false;
  spdlog::info(fmt::format("{}: the camera delivers again after {:.1f} s; going on", id,
                           clock.now_s() - lost_s));
  return true;
}

}  // namespace planar
