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
  bool position_certain{true};        ///< false after a power cycle or an abrupt stop, until homed
  bool homing{false};                 ///< on its way to its home switch
  bool answers{true};                 ///< false: out of touch; only `faults` says something then
  std::vector<std::string> faults{};  ///< in words; empty when the drive is well
};

struct DriveLimits {
  double speed_pulses_s{0.0};
  double acceleration_pulses_s2{0.0};
};

enum class HomeDirection { kReverse, kForward };

/// One motor that turns by pulses.
class PulseDrive {
 public:
  virtual ~PulseDrive() = default;
  virtual void energize() = 0;
  virtual void set_limits(const DriveLimits& limits) = 0;

  /// Starts a move to an absolute position. Refused with WorkError while de-energized or faulty.
  virtual void set_target(std::int32_t target_pulses) = 0;

  /// Stops at once and stays where it is.
  virtual void halt() = 0;
  virtual DriveStatus status() = 0;

  /// Starts the search for the home switch; the status tells when it has ended, and whether the
  /// position is certain then. It is 0 at the switch.
  virtual void start_homing(HomeDirection direction) = 0;

  /// Declares where the motor stands, which makes its position certain. Only at rest.
  virtual void set_position(std::int32_t position_pulses) = 0;
};

}  // namespace planar
