#pragma once

#include <array>
#include <cstdint>

#include "planar_servo/core/error.h"
#include "planar_servo/devices/pulse_drive.h"

namespace planar {

/// A drive failed, refuses or is not ready: what may pass while the program runs.
class DriveError : public WorkError {
 public:
  using WorkError::WorkError;
};

/// The three motors of an arm, spoken to together: what goes to all of them goes at the same time.
/// Joints count from 0; errors name drives as people count them, from 1.
class DriveGroup {
 public:
  virtual ~DriveGroup() = default;
  /// Switches all on, in the order of the joints or at once; none moves.
  virtual void energize() = 0;
  virtual void set_limits(const std::array<DriveLimits, 3>& limits) = 0;

  /// Starts a move to absolute positions. Throws DriveError when a drive refuses; the others may
  /// have started then.
  virtual void set_targets(const std::array<std::int32_t, 3>& targets_pulses) = 0;

  /// Stops every motor at once, whatever happens to the others; throws DriveError naming those that
  /// could not be told.
  virtual void halt() = 0;

  /// A drive that is out of touch says so in its status; that is not thrown.
  virtual std::array<DriveStatus, 3> status() = 0;

  /// As PulseDrive has them, for one joint.
  virtual void start_homing(int joint, HomeDirection direction) = 0;
  virtual void set_position(int joint, std::int32_t position_pulses) = 0;

  /// Tries once to get back into touch with the drives that do not answer.
  virtual void reconnect() = 0;
};

}  // namespace planar
