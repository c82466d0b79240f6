#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "planar_servo/core/clock.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/devices/board_presenter.h"
#include "planar_servo/devices/drive_group.h"
#include "planar_servo/devices/frame_source.h"
#include "planar_servo/devices/tracker.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_hardware.h"

namespace planar {

/// A cell that exists only here: arm, camera, lamps and tracker behind the interfaces of real
/// devices, on a clock of their own. Only its own devices and the scorer see the truth. The same
/// truth and the same calls give the same bytes.
class VirtualCell {
 public:
  /// Throws std::invalid_argument for hardware that cannot be: an empty sensor, a frame rate, scale
  /// or limit that is not finite and positive (scales may be negative), a sense other than +-1.
  VirtualCell(const Truth& truth, const VirtualHardware& hardware);
  ~VirtualCell();

  Clock& clock();
  FrameSource& camera();
  /// joint 0, 1 or 2; throws std::out_of_range otherwise.
  PulseDrive& drive(int joint);
  DriveGroup& drives();
  Tracker& tracker();
  BoardPresenter& board_presenter();

  /// Makes a drive report this fault, stop and refuse targets; an empty text heals it.
  void set_drive_fault(int joint, const std::string& fault);

  // For servers, which show this cell to others as real devices.
  /// What the camera's sensor shows now; see VirtualCamera::expose().
  cv::Mat expose(const cv::Rect& region_px, double brightness, std::uint64_t exposure);
  /// Turns a motor to a position from outside, by steps so small that it does not turn back on the
  /// way. Its drive takes no part.
  void turn_motor(int joint, std::int32_t pulses);

  /// For the scorer of `_truth` figures only: the end point P as it really is, in the base frame,
  /// and the direction from lamp 1 to lamp 2.
  TipPose true_tip() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
