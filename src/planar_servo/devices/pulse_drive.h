#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace planar {

struct DriveStatus {
  std::int32_t position_pulses{0};  ///< commanded position at this moment
  std::int32_t target_pulses{0};
  bool energized{false};
  bool moving{false};
  bool position_certain{true};        ///< false from a power cycle or an abrupt stop until homed
  bool homing{false};                 ///< whether the drive is moving to its home switch
  bool answers{true};                 ///< false when out of touch; then only `faults` is valid
  std::vector<std::string> faults{};  ///< in words; empty when the drive is well
};

struct DriveLimits {
  double speed_pulses_s{0.0};
  double acceleration_pulses_s2{0.0};
};

enum class HomeDirection { kReverse, kForward };

/// A drive that turns one motor by pulses.
class PulseDrive {
 public:
  virtual ~PulseDrive() = default;
  virtual void energize() = 0;
  virtual void set_limits(const DriveLimits& limits) = 0;

  /// Starts a move to an absolute position. Throws WorkError while the drive is off or faulty.
  virtual void set_target(std::int32_t target_pulses) = 0;

  /// Stops at once and holds the position.
  virtual void halt() = 0;
  virtual DriveStatus status() = 0;

  /// Starts the search for the home switch, whose position becomes 0. status() tells when the
  /// search has ended and whether the position is certain then.
  virtual void start_homing(HomeDirection direction) = 0;

  /// Declares the motor's position, which makes it certain. Allowed only at rest.
  virtual void set_position(std::int32_t position_pulses) = 0;
};

}  // namespace planar
