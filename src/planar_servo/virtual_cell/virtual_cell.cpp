#include "planar_servo/virtual_cell/virtual_cell.h"

#include <cmath>
#include <stdexcept>

#include "planar_servo/virtual_cell/virtual_arm.h"
#include "planar_servo/virtual_cell/virtual_board.h"
#include "planar_servo/virtual_cell/virtual_camera.h"
#include "planar_servo/virtual_cell/virtual_clock.h"
#include "planar_servo/virtual_cell/virtual_lens.h"
#include "planar_servo/virtual_cell/virtual_tracker.h"

namespace planar {
namespace {

const VirtualHardware& checked(const VirtualHardware& hardware) {
  const auto positive = [](const auto& values) {
    return values.allFinite() && (values.array() > 0.0).all();
  };
  if (hardware.sensor_px.empty() || !(hardware.frame_rate_hz > 0.0) ||
      !std::isfinite(hardware.frame_rate_hz))
    throw std::invalid_argument("a virtual camera needs pixels and a frame rate");
  if (std::abs(hardware.sense) != 1.0)
    throw std::invalid_argument("a virtual arm's sense must be +1 or -1");
  if (!positive(hardware.pulses_per_rad().cwiseAbs()) || !positive(hardware.max_speed_rad_s) ||
      !positive(hardware.max_acceleration_rad_s2) || !hardware.home_rad.allFinite())
    throw std::invalid_argument("a virtual drive's scale and limits must be finite and not zero");
  return hardware;
}

}  // namespace

struct VirtualCell::Impl {
  Impl(const Truth& truth, const VirtualHardware& hardware)
      : lens(truth.camera, truth.seed),
        arm(truth, checked(hardware), clock),
        board(truth, lens, hardware.sensor_px),
        camera(truth, hardware, lens, arm, board, clock),
        tracker(truth, hardware, arm, clock),
        drives({&arm.drive(0), &arm.drive(1), &arm.drive(2)}) {}

  VirtualClock clock;
  VirtualLens lens;
  VirtualArm arm;
  VirtualBoard board;
  VirtualCamera camera;
  VirtualTracker tracker;
  SeparateDrives drives;
};

VirtualCell::VirtualCell(const Truth& truth, const VirtualHardware& hardware)
    : impl_(std::make_unique<Impl>(truth, hardware)) {}
VirtualCell::~VirtualCell() = default;

Clock& VirtualCell::clock() {
  return impl_->clock;
}
FrameSource& VirtualCell::camera() {
  return impl_->camera;
}
PulseDrive& VirtualCell::drive(int joint) {
  return impl_->arm.drive(joint);
}
DriveGroup& VirtualCell::drives() {
  return impl_->drives;
}
Tracker& VirtualCell::tracker() {
  return impl_->tracker;
}
BoardPresenter& VirtualCell::board_presenter() {
  return impl_->board;
}

cv::Mat VirtualCell::expose(const cv::Rect& region_px, double brightness, std::uint64_t exposure) {
  return impl_->camera.expose(region_px, brightness, exposure);
}

void VirtualCell::turn_motor(int joint, std::int32_t pulses) {
  impl_->arm.drive(joint).turn_shaft(pulses);
}

TipPose VirtualCell::true_tip() const {
  return impl_->arm.tip();
}

}  // namespace planar
