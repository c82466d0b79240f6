#include "planar_servo/servo/path/gear_play.h"

#include <algorithm>

namespace planar {
namespace {

/// A motor that is wanted back by less than this is not on its way back: the corrections by vision
/// tremble by that much. 0.01 mm at an arm's length of 0.3 m.
constexpr double kTremble_rad = 3e-5;

}  // namespace

GearPlay::GearPlay(const Transmission& transmission, const Eigen::Vector3d& play_rad,
                   const Joints& theta)
    : transmission_(transmission),
      play_(play_rad),
      held_(transmission.motors_from_joints(theta)),
      extreme_(held_) {}

Joints GearPlay::behind(const Joints& drives) {
  const Eigen::Vector3d motors = transmission_.motors_from_joints(drives);
  held_ = held_.cwiseMax(motors).cwiseMin(motors + play_);
  return transmission_.joints_from_motors(held_);
}

Joints GearPlay::command(const Joints& wanted) {
  Eigen::Vector3d motors = transmission_.motors_from_joints(wanted);
  for (int i = 0; i < 3; ++i) {
    const double ahead = side_[i] * (motors[i] - extreme_[i]);
    if (ahead < -kTremble_rad) side_[i] = -side_[i];
    if (ahead > 0.0 || ahead < -kTremble_rad) extreme_[i] = motors[i];
    if (side_[i] < 0.0) motors[i] -= play_[i];
  }
  return transmission_.joints_from_motors(motors);
}

}  // namespace planar
