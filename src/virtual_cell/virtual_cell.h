#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <memory>

#include "core/clock.h"
#include "core/pose.h"
#include "devices/board_presenter.h"
#include "devices/frame_source.h"
#include "devices/pulse_drive.h"
#include "devices/tracker.h"
#include "virtual_cell/truth.h"

namespace planar {

/// What is known of the machine from its data sheets: the part of cell.yaml that is true of the
/// virtual cell as well.
struct VirtualHardware {
  cv::Size sensor_px{5120, 5120};
  double frame_rate_hz{15.0};
  double sense{1.0};                           ///< +1 counterclockwise, -1 clockwise
  std::array<bool, 2> relative{true, true};    ///< motors 2 and 3 ride on the link before
  Eigen::Vector3d pulses_per_rad{1.0, 1.0, 1.0};  ///< signed, of the motor angle behind its gear
  Eigen::Vector3d max_speed_rad_s{1.0, 1.0, 2.0};
  Eigen::Vector3d home_rad{0.0, 0.0, 0.0};     ///< joint angles at power-up
  std::vector<std::pair<std::string, Eigen::Vector3d>> monuments_B;  ///< metres, base frame
};

/// A cell that exists only here: arm, camera, lamps and tracker behind the interfaces of real
/// devices, on a clock of their own. Only its own devices and the scorer see the truth.
class VirtualCell {
 public:
  VirtualCell(const Truth& truth, const VirtualHardware& hardware);
  ~VirtualCell();

  Clock& clock();
  FrameSource& camera();
  PulseDrive& drive(int joint);
  Tracker& tracker();
  BoardPresenter& board_presenter();

  /// For the scorer of `_truth` figures only: the end point P as it really is, in the base frame.
  TipPose true_tip() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
