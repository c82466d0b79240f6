#pragma once

#include "planar_servo/arm/transmission.h"

namespace planar {

/// A motor's move from rest to rest as its drive makes it: at its full acceleration to its full
/// speed, and back to rest; a short one never reaches that speed. Radians behind the gear.
class MotorMove {
 public:
  /// Throws std::invalid_argument for angles that are not finite.
  MotorMove(double from_rad, double to_rad, const MotorDrive& drive);

  double duration_s() const { return 2.0 * ramp_s_ + cruise_s_; }

  /// Returns the angle so long after the beginning; at rest before and afterwards.
  double angle_at(double t_s) const;

 private:
  double from_, to_;
  double acceleration_;  ///< towards the end, signed
  double ramp_s_, cruise_s_;
};

}  // namespace planar
