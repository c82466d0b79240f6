#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>

#include "planar_servo/virtual_cell/truth/arm_truth.h"

namespace planar {

/// The data of the machine that the virtual cell takes from cell.yaml, unless the truth differs.
struct VirtualHardware {
  cv::Size sensor_px{5120, 5120};
  double frame_rate_hz{15.0};
  double sense{1.0};                         ///< +1 counterclockwise, -1 clockwise
  std::array<bool, 2> relative{true, true};  ///< whether motors 2 and 3 ride on the link before
  Eigen::Vector3d pulses_per_motor_turn{10000.0, 10000.0, 10000.0};
  Eigen::Vector3d gear_ratios{100.0, 100.0, 50.0};  ///< motor turns per joint turn
  Eigen::Vector3d directions{1.0, 1.0, 1.0};        ///< each +1 or -1
  Eigen::Vector3d max_speed_rad_s{1.0, 1.0, 2.0};
  Eigen::Vector3d max_acceleration_rad_s2{5.0, 5.0, 10.0};
  Eigen::Vector3d home_rad{0.0, 0.0, 0.0};  ///< joint angles at power-up
  VirtualMonuments monuments_B;

  /// Returns the signed scale of each motor's angle behind its gear.
  Eigen::Vector3d pulses_per_rad() const;
  /// Returns the motors' positions with the joints at home, whole pulses.
  Eigen::Vector3i home_pulses() const;
};

/// Returns the machine as built: by the truth where it says so, and the rest as stated. A monument
/// that the truth does not name stands where it is stated.
VirtualHardware as_built(const VirtualHardware& stated, const BuildTruth& build);

/// Returns a build that is as stated in every part.
BuildTruth build_as_stated(const VirtualHardware& stated);

}  // namespace planar
