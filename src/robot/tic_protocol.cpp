#include "robot/tic_protocol.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"

namespace planar::tic {
namespace {

constexpr double kSpeedUnits = 1e4;
constexpr double kAccelerationUnits = 1e2;
constexpr double kMaxAcceleration_pulses_s2 = 0x7fffffff / kAccelerationUnits;
constexpr double kMinSpeed_pulses_s = 7 / kSpeedUnits;  // 1 to 6 units act as none
constexpr double kMinAcceleration_pulses_s2 = 1.0;

/// By the bits of the error status; bit 0 means that the motor is switched off, which is no fault.
constexpr std::array<const char*, 9> kErrors{nullptr,
                                             "motor driver error",
                                             "low supply voltage",
                                             "kill switch active",
                                             "required input invalid",
                                             "serial error",
                                             "command timeout",
                                             "safe start: it has to be switched on again",
                                             "its ERR line is high"};

std::uint32_t in_units(const char* what, double value, double lower, double upper, double units) {
  if (!(value >= lower && value <= upper))
    throw InputError(
        fmt::format("a Tic's {} is {} pulses; it can be from {} to {}", what, value, lower, upper));
  return static_cast<std::uint32_t>(std::llround(value * units));
}

}  // namespace

std::uint32_t speed_units(double speed_pulses_s) {
  return in_units("speed per second", speed_pulses_s, kMinSpeed_pulses_s, kMaxSpeed_pulses_s,
                  kSpeedUnits);
}

std::uint32_t acceleration_units(double acceleration_pulses_s2) {
  return in_units("acceleration per second squared", acceleration_pulses_s2,
                  kMinAcceleration_pulses_s2, kMaxAcceleration_pulses_s2, kAccelerationUnits);
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

std::vector<std::string> StatusBlock::faults() const {
  std::vector<std::string> faults;
  const auto errors = read<std::uint16_t>(0x02);
  for (std::size_t bit = 1; bit < kErrors.size(); ++bit)
    if ((errors >> bit & 1) != 0) faults.emplace_back(kErrors[bit]);
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
