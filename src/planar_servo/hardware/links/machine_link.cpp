#include "planar_servo/hardware/links/machine_link.h"

#include <algorithm>
#include <cmath>

namespace planar {

MoveTime time_of(const Pulses& way, const std::array<DriveLimits, 3>& limits) {
  const auto& [first, second, third] = limits;
  const auto [speed, acceleration] = straight_pace(
      way.cast<double>(), {first.speed_pulses_s, second.speed_pulses_s, third.speed_pulses_s},
      {first.acceleration_pulses_s2, second.acceleration_pulses_s2, third.acceleration_pulses_s2});
  if (std::isinf(speed)) return {};
  const double ramp_s = std::min(speed / acceleration, std::sqrt(1.0 / acceleration));
  return {1.0 / (acceleration * ramp_s) + ramp_s, ramp_s};
}

}  // namespace planar
