#include "planar_servo/base/devices/drive_limits.h"

#include <fmt/format.h>

namespace planar {

void require_within(const std::array<DriveLimits, 3>& limits,
                    const std::array<DriveLimits, 3>& rated) {
  constexpr double kAllowedExcess = 1.001;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [speed, acceleration] = limits[i];
    if (!(speed > 0.0 && speed <= kAllowedExcess * rated[i].speed_pulses_s) ||
        !(acceleration > 0.0 && acceleration <= kAllowedExcess * rated[i].acceleration_pulses_s2))
      throw InputError({fmt::format("drive {} cannot keep {:g} pulses/s and {:g} pulses/s^2", i + 1,
                                    speed, acceleration),
                        fmt::format("its cell allows up to {:g} and {:g}", rated[i].speed_pulses_s,
                                    rated[i].acceleration_pulses_s2)});
  }
}

}  // namespace planar
