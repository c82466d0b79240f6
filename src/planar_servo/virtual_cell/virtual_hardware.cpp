#include "planar_servo/virtual_cell/virtual_hardware.h"

#include <algorithm>

#include "planar_servo/base/core/units.h"

namespace planar {

Eigen::Vector3d VirtualHardware::pulses_per_rad() const {
  return directions.cwiseProduct(pulses_per_motor_turn).cwiseProduct(gear_ratios) / (2.0 * kPi);
}

Eigen::Vector3i VirtualHardware::home_pulses() const {
  const Eigen::Vector3d motors(home_rad[0], home_rad[1] - (relative[0] ? home_rad[0] : 0.0),
                               home_rad[2] - (relative[1] ? home_rad[1] : 0.0));
  return pulses_per_rad().cwiseProduct(motors).array().round().cast<int>();
}

VirtualHardware as_built(const VirtualHardware& stated, const BuildTruth& build) {
  VirtualHardware built = stated;
  built.sense = build.sense.value_or(stated.sense);
  built.relative = build.relative.value_or(stated.relative);
  built.gear_ratios = build.gear_ratios.value_or(stated.gear_ratios);
  built.directions = build.directions.value_or(stated.directions);
  built.home_rad = build.home_rad.value_or(stated.home_rad);
  for (const auto& monument : build.monuments_B) {
    const auto same =
        std::find_if(built.monuments_B.begin(), built.monuments_B.end(),
                     [&](const auto& other) { return other.first == monument.first; });
    if (same == built.monuments_B.end())
      built.monuments_B.push_back(monument);
    else
      *same = monument;
  }
  return built;
}

BuildTruth build_as_stated(const VirtualHardware& stated) {
  return {stated.sense,      stated.relative, stated.gear_ratios,
          stated.directions, stated.home_rad, stated.monuments_B};
}

}  // namespace planar
