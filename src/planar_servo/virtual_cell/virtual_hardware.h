#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

namespace planar {

/// What the data sheets say of the machine: the part of cell.yaml that holds for the virtual cell
/// as well.
struct VirtualHardware {
  cv::Size sensor_px{5120, 5120};
  double frame_rate_hz{15.0};
  double sense{1.0};                         ///< +1 counterclockwise, -1 clockwise
  std::array<bool, 2> relative{true, true};  ///< whether motors 2 and 3 ride on the link before
  Eigen::Vector3d pulses_per_rad{1.0, 1.0, 1.0};  ///< signed, of the motor's angle behind its gear
  Eigen::Vector3d max_speed_rad_s{1.0, 1.0, 2.0};
  Eigen::Vector3d max_acceleration_rad_s2{5.0, 5.0, 10.0};
  Eigen::Vector3d home_rad{0.0, 0.0, 0.0};                           ///< joint angles at power-up
  std::vector<std::pair<std::string, Eigen::Vector3d>> monuments_B;  ///< metres, base frame
};

}  // namespace planar
