#include "planar_servo/virtual_cell/motion/reducer.h"

#include <algorithm>
#include <cmath>

namespace planar {

Reducer::Reducer(const ReducerTruth& truth, double motor_rad, double gear_ratio)
    : truth_(truth),
      gear_ratio_(gear_ratio),
      motor_rad_(motor_rad),
      held_rad_(shaft_rad(motor_rad)) {}

void Reducer::follow(double motor_rad) {
  if (motor_rad != motor_rad_) turned_negative_ = motor_rad < motor_rad_;
  motor_rad_ = motor_rad;
  const double half = 0.5 * truth_.backlash_rad;
  const double shaft = shaft_rad(motor_rad);
  const double held = std::clamp(held_rad_, shaft - half, shaft + half);
  wind(held - held_rad_);
  held_rad_ = held;
}

double Reducer::output_rad() const {
  double output = held_rad_ + truth_.zero_offset_rad;
  for (const Harmonic& h : truth_.eccentricity)
    output += h.amplitude * std::sin(h.order * held_rad_ + h.phase_rad);
  return output + ripple_rad() + wound_rad_;
}

double Reducer::shaft_rad(double motor_rad) const {
  double error = 0.0;
  for (const Harmonic& h : truth_.microsteps)
    error += h.amplitude * std::sin(h.order * gear_ratio_ * motor_rad + h.phase_rad);
  return motor_rad + error / gear_ratio_;
}

double Reducer::ripple_rad() const {
  constexpr double kAhead = 0.7;  // radians by which the swelling is ahead and behind
  double ripple = 0.0;
  for (const Harmonic& h : truth_.ripple) {
    const double wave = h.order * gear_ratio_ * held_rad_ + h.phase_rad;
    const double swelling = held_rad_ + h.phase_rad + kAhead * std::sin(2.0 * held_rad_);
    ripple += h.amplitude * (1.0 + truth_.ripple_modulation * std::sin(swelling)) *
              std::sin(wave + truth_.ripple_skew * std::sin(wave));
  }
  return ripple;
}

void Reducer::wind(double turn_rad) {
  if (turn_rad == 0.0) return;
  const double full = std::copysign(truth_.hysteresis_rad, turn_rad);
  wound_rad_ = full + (wound_rad_ - full) * std::exp(-std::abs(turn_rad) / truth_.forgetting_rad);
}

}  // namespace planar
