#include "planar_servo/robot/velocity_move.h"

#include <algorithm>
#include <cmath>

namespace planar {
namespace {

/// The least limit of speed (pulses/s) and acceleration (pulses/s^2). Drives take no limit of 0,
/// and a motor as slow as this counts as resting.
constexpr double kLeastLimit = 1.0;

Eigen::Vector3d scaled(const Eigen::Vector3d& velocity, const std::array<DriveLimits, 3>& rated) {
  double excess = 1.0;
  for (std::size_t i = 0; i < 3; ++i)
    excess = std::max(excess, std::abs(velocity[i]) / rated[i].speed_pulses_s);
  return velocity / excess;
}

/// Returns the present velocity of a motor that changes from one velocity to another with its
/// acceleration.
double velocity_now(const VelocityMove& last, std::size_t i, double now_s) {
  const double change = last.limits[i].acceleration_pulses_s2 * (now_s - last.t_s);
  return last.from[i] + std::clamp(last.velocity[i] - last.from[i], -change, change);
}

/// Returns the accelerations with which all motors make these changes of velocity in the same time,
/// which is the shortest that their limits allow.
Eigen::Vector3d in_one_time(const Eigen::Vector3d& changes,
                            const std::array<DriveLimits, 3>& rated) {
  double duration_s = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    duration_s = std::max(duration_s, std::abs(changes[i]) / rated[i].acceleration_pulses_s2);
  if (duration_s == 0.0) return Eigen::Vector3d::Zero();
  return changes.cwiseAbs() / duration_s;
}

double braking_way(double velocity, double acceleration) {
  return velocity * velocity / (2.0 * acceleration);
}

}  // namespace

VelocityMove velocity_move(const VelocityMove& last, double now_s,
                           const std::array<DriveStatus, 3>& status,
                           const Eigen::Vector3d& velocity, const std::array<DriveLimits, 3>& rated,
                           double hold_s) {
  VelocityMove move;
  move.t_s = now_s;
  move.velocity = scaled(velocity, rated);
  for (std::size_t i = 0; i < 3; ++i)
    if (status[i].moving) move.from[i] = velocity_now(last, i, now_s);
  const Eigen::Vector3d changing = in_one_time(move.velocity - move.from, rated);
  const Eigen::Vector3d braking = in_one_time(move.velocity, rated);
  for (std::size_t i = 0; i < 3; ++i) {
    const double acceleration = std::max({kLeastLimit, changing[i], braking[i]});
    const double position = status[i].position_pulses;
    const double v = move.velocity[i];
    const bool turns = std::abs(v) > kLeastLimit;
    double ahead = v * hold_s + std::copysign(braking_way(v, acceleration), v);
    if (!turns) {
      const double way = braking_way(move.from[i], acceleration);
      ahead = std::clamp(status[i].target_pulses - position, -way, way);
    }
    move.limits[i] = {std::max(kLeastLimit, std::abs(turns ? v : move.from[i])), acceleration};
    move.targets_pulses[i] = static_cast<std::int32_t>(std::lround(position + ahead));
  }
  return move;
}

}  // namespace planar
