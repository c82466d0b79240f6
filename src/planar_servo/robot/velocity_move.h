#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "planar_servo/devices/pulse_drive.h"

namespace planar {

/// Holds what three motors are told in order to turn at given velocities (pulses/s), although they
/// only know how to go to positions, and how fast they turned when they were told.
struct VelocityMove {
  double t_s{0.0};
  Eigen::Vector3d from{0.0, 0.0, 0.0};      ///< their velocities at t_s
  Eigen::Vector3d velocity{0.0, 0.0, 0.0};  ///< what they speed up or slow down to
  std::array<DriveLimits, 3> limits;
  std::array<std::int32_t, 3> targets_pulses{};
};

/// Returns the move that makes motors of this `status`, whose last move was `last`, turn at
/// `velocity` for `hold_s` and then slow down to rest, unless they are told anew before. Each
/// target lies ahead by that time and the way to brake. A velocity beyond the `rated` limits is
/// scaled as a whole. All motors change their velocity in the same time, and brake in the same
/// time, within their rated accelerations. A motor that is to rest does not go farther than it was
/// going already.
VelocityMove velocity_move(const VelocityMove& last, double now_s,
                           const std::array<DriveStatus, 3>& status,
                           const Eigen::Vector3d& velocity, const std::array<DriveLimits, 3>& rated,
                           double hold_s);

}  // namespace planar
