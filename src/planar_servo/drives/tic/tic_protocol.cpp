#include "planar_servo/drives/tic/tic_protocol.h"

#include <fmt/format.h>

#include <cmath>

namespace planar::tic {
namespace {

constexpr double kSpeedUnits = 1e4;         // per pulse/s
constexpr double kAccelerationUnits = 1e2;  // per pulse/s^2
constexpr double kMaxAcceleration = 0x7fffffff / kAccelerationUnits;
constexpr double kMinSpeed = 7 / kSpeedUnits;  // a Tic takes 1 to 6 units as none
constexpr double kMinAcceleration = 1.0;

/// Names the bits of the error status. Bit 0 means that the motor is off, which is no fault.
constexpr std::array<const char*, 9> kErrors{nullptr,
                                             "motor driver error",
                                             "low supply voltage",
                                             "kill switch active",
                                             "required input invalid",
                                             "serial error",
                                             "command timeout",
                                             "safe start: it has to be switched on again",
                                             "its ERR line is high"};

/// The bits for driver error, serial error, command timeout and safe start.
constexpr unsigned kClearedByCommands = 1U << 1 | 1U << 5 | 1U << 6 | 1U << 7;

std::uint32_t in_units(const char* what, double value, double lower, double upper, double units) {
  if (!(value >= lower && value <= upper))
    throw InputError(
        fmt::format("a Tic's {} is {} pulses; it can be from {} to {}", what, value, lower, upper));
  return static_cast<std::uint32_t>(std::llround(value * units));
}

}  // namespace

std::uint32_t speed_units(double speed_pulses_s) {
  return in_units("speed per second", speed_pulses_s, kMinSpeed, kMaxSpeed, kSpeedUnits);
}

std::uint32_t acceleration_units(double acceleration_pulses_s2) {
  return in_units("acceleration per second squared", acceleration_pulses_s2, kMinAcceleration,
                  kMaxAcceleration, kAccelerationUnits);
}

std::optional<Refusal> unfitness(std::uint16_t firmware,
                                 const std::vector<std::uint8_t>& settings) {
  const auto setting = [&](Setting which) { return settings.at(static_cast<std::size_t>(which)); };
  if (firmware < kOldestFirmware)
    return Refusal{fmt::format("its firmware {} is too old", firmware_name(firmware)),
                   fmt::format("upgrade it to {} or later with Pololu's Tic Control Center",
                               firmware_name(kOldestFirmware))};
  if (setting(Setting::kControlMode) != kControlModeUsb)
    return Refusal{fmt::format("its control mode is {}, in which it ignores this program",
                               setting(Setting::kControlMode)),
                   "set it to 'Serial / I2C / USB' in Pololu's Tic Control Center"};
  if (setting(Setting::kDisableSafeStart) != 0)
    return Refusal{"its safe start is disabled, so that it could move by surprise",
                   "enable it in Pololu's Tic Control Center"};
  return std::nullopt;
}

std::string product_name(std::uint16_t product_id) {
  switch (product_id) {
    case 0x00b3:
      return "Tic T825";
    case 0x00b5:
      return "Tic T834";
    case 0x00bd:
      return "Tic T500";
    case 0x00c3:
      return "Tic N825";
    case 0x00c9:
      return "Tic T249";
    case 0x00cb:
      return "Tic 36v4";
    default:
      return "";
  }
}

std::string firmware_name(std::uint16_t bcd) {
  return fmt::format("{:x}.{:02x}", bcd >> 8, bcd & 0xff);
}

std::int32_t StatusBlock::target() const {
  return bytes_[0x09] == kToPosition ? read<std::int32_t>(0x0a) : position();
}

bool StatusBlock::limit_in_the_way() const {
  return (flag(kForwardLimit) && target() > position()) ||
         (flag(kReverseLimit) && target() < position());
}

bool StatusBlock::moving() const {
  const auto velocity = read<std::int32_t>(0x26);
  return velocity != 0 || homing() || (target() != position() && !limit_in_the_way());
}

std::vector<std::string> StatusBlock::errors_among(unsigned bits) const {
  std::vector<std::string> errors;
  for (std::size_t bit = 1; bit < kErrors.size(); ++bit)
    if ((read<std::uint16_t>(0x02) & bits) >> bit & 1) errors.emplace_back(kErrors[bit]);
  return errors;
}

std::vector<std::string> StatusBlock::standing_faults() const {
  return errors_among(~kClearedByCommands);
}

std::vector<std::string> StatusBlock::faults() const {
  std::vector<std::string> faults = errors_among(~0U);
  if (limit_in_the_way() && !homing())
    faults.emplace_back(flag(kForwardLimit) ? "it stands on its forward limit switch"
                                            : "it stands on its reverse limit switch");
  return faults;
}

DriveStatus StatusBlock::drive_status() const {
  DriveStatus status;
  status.position_pulses = position();
  status.target_pulses = target();
  status.energized = ready();
  status.moving = moving();
  status.position_certain = position_certain();
  status.homing = homing();
  status.faults = faults();
  return status;
}

}  // namespace planar::tic
