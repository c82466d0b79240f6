#include "planar_servo/virtual_cell/motion/virtual_arm.h"

#include <cmath>

namespace planar {

VirtualArm::VirtualArm(const Truth& truth, const VirtualHardware& stated, const Clock& clock)
    : arm_(truth.arm), tool_(truth.tool) {
  const VirtualHardware built = as_built(stated, truth.build);
  sense_ = built.sense;
  relative_ = built.relative;
  const Eigen::Vector3d scales = built.pulses_per_rad(), rated = stated.pulses_per_rad().cwiseAbs();
  const Eigen::Vector3i home = built.home_pulses(), counted = stated.home_pulses();
  for (int joint = 0; joint < 3; ++joint) {
    const MotionLimits limits{rated[joint] * stated.max_speed_rad_s[joint],
                              rated[joint] * stated.max_acceleration_rad_s2[joint]};
    drives_.emplace_back(clock,
                         VirtualDrive::Settings{scales[joint], limits, home[joint], counted[joint]},
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
