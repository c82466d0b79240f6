#include "planar_servo/base/devices/drive_group.h"

#include <fmt/format.h>

namespace planar {

void SeparateDrives::energize() {
  for (PulseDrive* drive : drives_) drive->energize();
}

void SeparateDrives::set_limits(const std::array<DriveLimits, 3>& limits) {
  for (std::size_t i = 0; i < 3; ++i) drives_[i]->set_limits(limits[i]);
}

void SeparateDrives::set_targets(const std::array<std::int32_t, 3>& targets_pulses) {
  for (std::size_t i = 0; i < 3; ++i) drives_[i]->set_target(targets_pulses[i]);
}

void SeparateDrives::halt() {
  std::string failures;
  for (std::size_t i = 0; i < 3; ++i) {
    try {
      drives_[i]->halt();
    } catch (const std::exception& error) {
      failures += (failures.empty() ? "" : "; ") + ("drive " + std::to_string(i + 1)) +
                  " does not halt: " + error.what();
    }
  }
  if (!failures.empty()) throw DriveError(failures);
}

std::array<DriveStatus, 3> SeparateDrives::status() {
  return {drives_[0]->status(), drives_[1]->status(), drives_[2]->status()};
}

void SeparateDrives::start_homing(int joint, HomeDirection direction) {
  drives_.at(static_cast<std::size_t>(joint))->start_homing(direction);
}

void SeparateDrives::set_position(int joint, std::int32_t position_pulses) {
  drives_.at(static_cast<std::size_t>(joint))->set_position(position_pulses);
}

void SeparateDrives::forget_positions() {
  for (PulseDrive* drive : drives_) drive->forget_position();
}

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
