#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "planar_servo/core/error.h"
#include "planar_servo/devices/pulse_drive.h"

namespace planar {

/// A drive failed, refuses a command or is not ready. It may recover while the program runs.
class DriveError : public WorkError {
 public:
  using WorkError::WorkError;
};

/// Commands the three motors of an arm at the same time. Joints count from 0; error messages number
/// the drives from 1.
class DriveGroup {
 public:
  virtual ~DriveGroup() = default;
  /// Switches all motors on; none moves.
  virtual void energize() = 0;
  virtual void set_limits(const std::array<DriveLimits, 3>& limits) = 0;

  /// Starts moves to absolute positions. Throws DriveError when a drive refuses; the others may
  /// have started then.
  virtual void set_targets(const std::array<std::int32_t, 3>& targets_pulses) = 0;

  /// Stops every motor at once, whatever happens to the others. Throws DriveError naming the drives
  /// that could not be told.
  virtual void halt() = 0;

  /// Reads all drives. A drive that does not answer says so in its status; nothing is thrown.
  virtual std::array<DriveStatus, 3> status() = 0;

  /// These two command one joint; see PulseDrive.
  virtual void start_homing(int joint, HomeDirection direction) = 0;
  virtual void set_position(int joint, std::int32_t position_pulses) = 0;

  /// Returns in words why new targets every few hundredths of a second do not make one smooth
  /// motion of these drives; empty when they do.
  virtual std::optional<std::string> stream_refusal() const { return std::nullopt; }

  /// Tries once to open the drives again that do not answer.
  virtual void reconnect() = 0;
};

}  // namespace planar
