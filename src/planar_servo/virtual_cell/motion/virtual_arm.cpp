#include "planar_servo/virtual_cell/motion/virtual_arm.h"

#include <cmath>

namespace planar {

VirtualArm::VirtualArm(const Truth& truth, const VirtualHardware& hardware, const Clock& clock)
    : arm_(truth.arm), tool_(truth.tool), sense_(hardware.sense), relative_(hardware.relative) {
  const Eigen::Vector3d& home = hardware.home_rad;
  const Eigen::Vector3d motors(home[0], home[1] - (relative_[0] ? home[0] : 0.0),
                               home[2] - (relative_[1] ? home[1] : 0.0));
  for (int joint = 0; joint < 3; ++joint) {
    const double scale = hardware.pulses_per_rad[joint];
    const MotionLimits rated{std::abs(scale) * hardware.max_speed_rad_s[joint],
                             std::abs(scale) * hardware.max_acceleration_rad_s2[joint]};
    const auto home_pulses = static_cast<std::int32_t>(std::lround(scale * motors[joint]));
    drives_.emplace_back(clock, VirtualDrive::Settings{scale, rated, home_pulses},
                         arm_.reducers[static_cast<std::size_t>(joint)]);
  }
}

VirtualDrive& VirtualArm::drive(int joint) {
  return drives_.at(static_cast<std::size_t>(joint));
}

Eigen::Vector3d VirtualArm::directions_rad() {
  Eigen::Vector3d theta(drives_[0].output_rad(), drives_[1].output_rad(), drives_[2].output_rad());
  if (relative_[0]) theta[1] += theta[0];
  if (relative_[1]) theta[2] += theta[1];
  return sense_ * theta;
}

Pose VirtualArm::X_BT() {
  const Eigen::Vector3d direction = directions_rad();
  const Eigen::Vector2d p = arm_.link_lengths_m[0] * rotation2d(direction[0]).col(0) +
                            arm_.link_lengths_m[1] * rotation2d(direction[1]).col(0);
  const double height = tool_.lamp_height_m - arm_.sag_m_per_m2 * p.squaredNorm();
  Pose X_BT = Pose::Identity();
  X_BT.translation() << p, height;
  X_BT.linear().topLeftCorner<2, 2>() = rotation2d(direction[2]);
  return X_BT;
}

TipPose VirtualArm::tip() {
  const Pose tool = X_BT();
  const Eigen::Vector2d lamps =
      tool.linear().topLeftCorner<2, 2>() * (tool_.lamps_m[1] - tool_.lamps_m[0]);
  return {tool.translation().head<2>(), std::atan2(lamps.y(), lamps.x())};
}

}  // namespace planar
