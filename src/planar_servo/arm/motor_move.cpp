#include "planar_servo/arm/motor_move.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace planar {

MotorMove::MotorMove(double from_rad, double to_rad, const MotorDrive& drive)
    : from_(from_rad),
      to_(to_rad),
      acceleration_(std::copysign(drive.max_acceleration_rad_s2, to_rad - from_rad)) {
  const double distance = std::abs(to_rad - from_rad), speed = drive.max_speed_rad_s;
  if (!std::isfinite(distance)) throw std::invalid_argument("motor angles must be finite");
  const double peak = std::min(speed, std::sqrt(distance * drive.max_acceleration_rad_s2));
  ramp_s_ = peak / drive.max_acceleration_rad_s2;
  cruise_s_ = peak < speed ? 0.0 : distance / speed - ramp_s_;
}

double MotorMove::angle_at(double t_s) const {
  const double left_s = duration_s() - t_s;
  if (t_s <= 0.0) return from_;
  if (left_s <= 0.0) return to_;
  if (t_s < ramp_s_) return from_ + 0.5 * acceleration_ * t_s * t_s;
  if (left_s < ramp_s_) return to_ - 0.5 * acceleration_ * left_s * left_s;
  return from_ + acceleration_ * ramp_s_ * (t_s - 0.5 * ramp_s_);
}

}  // namespace planar
