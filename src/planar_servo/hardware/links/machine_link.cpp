#include "planar_servo/hardware/links/machine_link.h"

#include <algorithm>
#include <cmath>

namespace planar {

MoveTime time_of(const Pulses& way, const std::array<DriveLimits, 3>& limits) {
  // Of the share of the way that is done, per second and per second squared.
  double speed = HUGE_VAL, acceleration = HUGE_VAL;
  for (std::size_t i = 0; i < 3; ++i) {
    const double length = std::abs(static_cast<double>(way[static_cast<int>(i)]));
    if (length == 0.0) continue;
    speed = std::min(speed, limits[i].speed_pulses_s / length);
    acceleration = std::min(acceleration, limits[i].acceleration_pulses_s2 / length);
  }
  if (std::isinf(speed)) return {};
  const double ramp_s = std::min(speed / acceleration, std::sqrt(1.0 / acceleration));
  return {1.0 / (acceleration * ramp_s) + ramp_s, ramp_s};
}

}  // namespace planar
