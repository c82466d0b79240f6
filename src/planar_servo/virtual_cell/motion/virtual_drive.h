#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/core/clock.h"
#include "planar_servo/devices/pulse_drive.h"
#include "planar_servo/virtual_cell/motion/motion_profile.h"
#include "planar_servo/virtual_cell/motion/motor_warmth.h"
#include "planar_servo/virtual_cell/motion/reducer.h"

namespace planar {

/// A stepper motor with its reducer. It moves in whole pulses within its limits of speed and
/// acceleration, on the clock that it is given.
class VirtualDrive final : public PulseDrive {
 public:
  struct Settings {
    double pulses_per_rad{1.0};      ///< signed, of the motor's angle behind its gear
    MotionLimits rated_pulses;       ///< pulses/s and pulses/s^2; set_limits() cannot exceed them
    std::int32_t home_pulses{0};     ///< of the shaft at first, and at the home switch
    std::int32_t counted_pulses{0};  ///< what the drive counts there at first
    double gear_ratio{1.0};          ///< motor turns per turn behind the gear, as built
    std::optional<ArmWarmingTruth> warming{};
  };

  VirtualDrive(const Clock& clock, const Settings& settings, const ReducerTruth& reducer);

  void energize() override;
  /// Cuts limits above the rated ones down to these. Throws std::invalid_argument unless both
  /// limits are finite and positive.
  void set_limits(const DriveLimits& limits) override;
  void set_target(std::int32_t target_pulses) override;
  void halt() override;
  DriveStatus status() override;
  /// Moves to the home switch, which stands at the drive's first position.
  void start_homing(HomeDirection direction) override;
  void set_position(std::int32_t position_pulses) override;

  /// Has this called whenever the shaft, or its drive with a new target, is about to turn.
  void before_turning(std::function<void()> call) { before_turning_ = std::move(call); }

  /// Makes the drive fail with this message: it stops at once and refuses targets. An empty text
  /// ends the fault.
  void set_fault(const std::string& fault);

  /// Turns the motor's shaft from outside, without the drive, to where the drive counted these
  /// pulses at first.
  void turn_shaft(std::int32_t pulses);

  /// Returns the true angle behind the reducer now.
  double output_rad();

  /// Returns where the shaft rests; empty while it moves.
  std::optional<std::int32_t> rest_pulses() const;

  /// Returns the time at which the shaft last came to rest, or will.
  double rests_since_s() const { return rests_since_s_; }

  /// Returns the motor's angle behind its gear now, if motor and gear had no errors.
  double motor_rad() const { return shaft_pulses() / settings_.pulses_per_rad; }

  /// Returns whether the motor last turned towards smaller angles behind its gear.
  bool turned_negative();

  Warmth warmth() const;

 private:
  void require_ready() const;
  void turn_to(std::int32_t shaft_target_pulses);
  /// The shaft turns from now until then.
  void note_turning(double until_s);
  /// Lets the reducer follow the motor up to the present.
  void advance();
  std::int32_t shaft_pulses() const;
  bool moving() const { return profile_.end_s() > clock_.now_s(); }

  const Clock& clock_;
  Settings settings_;
  MotionLimits limits_;
  MotionProfile profile_;  ///< of the shaft
  Reducer reducer_;
  std::optional<MotorWarmth> warmth_;
  std::function<void()> before_turning_{[] {}};
  double followed_until_s_;
  double rests_since_s_{-std::numeric_limits<double>::infinity()};
  std::int32_t target_pulses_;  ///< of the shaft
  /// Added to the shaft's position, gives the drive's count.
  std::int32_t counter_offset_pulses_;
  bool homing_{false};
  bool energized_{false};
  bool position_certain_{true};
  std::vector<std::string> faults_;
};

}  // namespace planar
