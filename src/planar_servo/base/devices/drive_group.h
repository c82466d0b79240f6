#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"

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
  /// Whether a person or a safety circuit may have stopped it, as by a hold or an emergency stop.
  bool stopped_by_hand{false};
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
  /// Halts the motor and makes its position uncertain.
  virtual void forget_position() = 0;
};

/// A drive failed, refuses a command or is not ready. It may recover while the program runs.
class DriveError : public WorkError {
 public:
  explicit DriveError(const std::string& fault, Cause cause = Cause::kDevice)
      : WorkError(fault, cause) {}
  using WorkError::WorkError;
};

/// A person or a safety circuit stopped the arm: nobody but a person may have it move again.
class StoppedByHand : public DriveError {
 public:
  using DriveError::DriveError;
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

  /// Brakes the motors of a move to rest. The targets lie on their way, as far ahead as their
  /// greatest acceleration takes; drives that brake by themselves come to rest elsewhere.
  virtual void brake_towards(const std::array<std::int32_t, 3>& targets_pulses) {
    set_targets(targets_pulses);
  }

  /// Stops every motor at once, whatever happens to the others. Throws DriveError naming the drives
  /// that could not be told.
  virtual void halt() = 0;

  /// Reads all drives. A drive that does not answer says so in its status; nothing is thrown.
  virtual std::array<DriveStatus, 3> status() = 0;

  /// These two command one joint; see PulseDrive.
  virtual void start_homing(int joint, HomeDirection direction) = 0;
  virtual void set_position(int joint, std::int32_t position_pulses) = 0;

  /// Makes every drive unsure of its position, at rest, also for others that use these drives.
  /// Throws DriveError naming those that could not be told.
  virtual void forget_positions() = 0;

  /// Returns in words why new targets every few hundredths of a second do not make one smooth
  /// motion of these drives; empty when they do.
  virtual std::optional<std::string> stream_refusal() const { return std::nullopt; }

  /// Tries once to open the drives again that do not answer.
  virtual void reconnect() = 0;
};

/// Commands three drives that share no bus one after the other.
class SeparateDrives final : public DriveGroup {
 public:
  /// The drives must outlive the group.
  explicit SeparateDrives(const std::array<PulseDrive*, 3>& drives) : drives_(drives) {}

  void energize() override;
  void set_limits(const std::array<DriveLimits, 3>& limits) override;
  void set_targets(const std::array<std::int32_t, 3>& targets_pulses) override;
  void halt() override;
  std::array<DriveStatus, 3> status() override;
  void start_homing(int joint, HomeDirection direction) override;
  void set_position(int joint, std::int32_t position_pulses) override;
  void forget_positions() override;
  void reconnect() override {}  ///< such drives are never out of touch

 private:
  std::array<PulseDrive*, 3> drives_;
};

/// Throws InputError for limits that are not positive, or beyond those of the cell's motors.
void require_within(const std::array<DriveLimits, 3>& limits,
                    const std::array<DriveLimits, 3>& rated);

}  // namespace planar
