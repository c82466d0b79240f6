#include "planar_servo/virtual_cell/motion/reducer.h"

#include <algorithm>
#include <cmath>

namespace planar {

void Reducer::follow(double motor_rad) {
  const double half = 0.5 * truth_.backlash_rad;
  held_rad_ = std::clamp(held_rad_, motor_rad - half, motor_rad + half);
}

double Reducer::output_rad() const {
  double output = held_rad_ + truth_.zero_offset_rad;
  for (const Harmonic& h : truth_.eccentricity)
    output += h.amplitude * std::sin(h.order * held_rad_ + h.phase_rad);
  return output;
}

}  // namespace planar
