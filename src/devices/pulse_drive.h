#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace planar {

struct DriveStatus {
  std::int32_t position_pulses{0};  ///< where the motor was commanded to be by now
  std::int32_t target_pulses{0};
  bool energized{false};
  bool moving{false};
  bool position_certain{true};      ///< false after a power cycle or an abrupt stop
  std::vector<std::string> faults;  ///< in words; empty when the drive is well
};

/// One motor that turns by pulses. Speeds are in pulses/s, accelerations in pulses/s^2.
class PulseDrive {
 public:
  virtual ~PulseDrive() = default;
  virtual void energize() = 0;
  virtual void set_limits(double max_speed_pulses_s, double max_acceleration_pulses_s2) = 0;

  /// Starts a move to an absolute position. Refused with WorkError while de-energized or faulty.
  virtual void set_target(std::int32_t target_pulses) = 0;

  /// Stops at once and stays where it is.
  virtual void halt() = 0;
  virtual DriveStatus status() = 0;
};

}  // namespace planar
