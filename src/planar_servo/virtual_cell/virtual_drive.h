#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// A clock whose time passes only when somebody waits.
class VirtualClock final : public Clock {
 public:
  double now_s() const override { return now_s_; }
  /// Throws std::invalid_argument for a duration that is negative or not finite.
  void sleep_for_s(double duration_s) override {
    if (!std::isfinite(duration_s) || duration_s < 0.0)
      throw std::invalid_argument("a duration to wait must be finite and not negative");
    now_s_ += duration_s;
  }
  /// Waits until a time that is not before now.
  void advance_to(double t_s) { sleep_for_s(t_s - now_s_); }

 private:
  double now_s_{0.0};
};

struct MotionState {
  double position{0.0};
  double velocity{0.0};
};

struct MotionLimits {
  double speed{1.0};
  double acceleration{1.0};
};

/// The fastest motion with bounded speed and acceleration from a moving start to rest at a target.
/// It is a trapezoid; when the start moves away from the target, or too fast to stop at it, the
/// motion stops first.
class MotionProfile {
 public:
  /// Rests at `position`.
  explicit MotionProfile(double position) : end_{position, 0.0} {}
  MotionProfile(double start_s, const MotionState& start, double target,
                const MotionLimits& limits);

  MotionState state_at(double t_s) const;
  double end_s() const { return end_s_; }

  /// Returns the positions, passed in (from_s, to_s], at which the velocity may change its sign.
  /// The motion between two of them is monotone.
  std::vector<double> turning_points(double from_s, double to_s) const;

 private:
  struct Phase {
    double start_s;
    MotionState start;
    double acceleration;
  };
  /// Appends a phase that begins where the last one ended.
  void append(double acceleration, double duration_s);

  std::vector<Phase> phases_;
  MotionState end_;  ///< after all phases
  double end_s_{0.0};
};

/// The warmth of a motor and of the link that it warms. 0 is cold; 1 is reached after an hour of
/// regular work from cold, in which the motor turns for 30 % of the time.
struct Warmth {
  double motor{0.0};
  double link{0.0};
};

/// The heat of a motor that turns or is held at rest, with the link that it warms. The motor
/// follows its heating with one time constant, the link follows the motor with another.
class MotorWarmth {
 public:
  explicit MotorWarmth(const ArmWarmingTruth& truth);

  /// Notes that the motor turns from `t_s` until `turns_until_s` and is then held, if energized.
  void work(double t_s, double turns_until_s, bool energized);

  /// Returns the warmth at a time, which must not be before the last work().
  Warmth at(double t_s) const;

 private:
  Warmth warmed(double t_s) const;
  Warmth after(const Warmth& from, double heat, double duration_s) const;

  ArmWarmingTruth truth_;
  Warmth regular_;  ///< after an hour of regular work
  Warmth last_;     ///< at `last_s_`
  double last_s_{0.0};
  double turns_until_s_{0.0};
  double holding_{0.0};  ///< heat at rest
};

/// A gear with all errors of it and its motor, between the motor's angle (divided by the gear
/// ratio) and the output angle.
class Reducer {
 public:
  /// Starts in the middle of the play.
  Reducer(const ReducerTruth& truth, double motor_rad, double gear_ratio = 1.0);

  /// Follows the motor to this angle, which it reached without turning back (the play operator).
  void follow(double motor_rad);

  /// Returns the angle behind the gear, with its zero offset.
  double output_rad() const;

  /// Returns whether the motor last turned towards smaller angles.
  bool turned_negative() const { return turned_negative_; }

 private:
  /// Returns where the motor's shaft stands when its drive says this.
  double shaft_rad(double motor_rad) const;
  /// Returns the transmission error over the motor's turn: waves that are steeper on one side and
  /// swell and fade as the output turns.
  double ripple_rad() const;
  /// Winds the gear up by the friction of a turn, by Dahl's model without a load.
  void wind(double turn_rad);

  ReducerTruth truth_;
  double gear_ratio_;
  double motor_rad_;
  double held_rad_;  ///< the angle on the far side of the play
  double wound_rad_{0.0};
  bool turned_negative_{false};
};

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
    bool position_certain{true};  ///< at first
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
  void forget_position() override;

  /// Sets a function that is called whenever the shaft, or its drive with a new target, is about to
  /// turn.
  void before_turning(std::function<void()> call) { before_turning_ = std::move(call); }

  /// Turns the motor's shaft from outside, without the drive, to where the drive counted these
  /// pulses at first.
  void turn_shaft(std::int32_t pulses);

  /// Returns the true angle behind the reducer now.
  double output_rad();

  /// Returns where the shaft rests; empty while it moves.
  std::optional<std::int32_t> rest_pulses() const;

  /// Returns the time at which the shaft last came to rest, or will.
  double rests_since_s() const { return rests_since_s_; }

  /// Returns the motor's present angle behind its gear, as if motor and gear had no errors.
  double motor_rad() const { return shaft_pulses() / settings_.pulses_per_rad; }

  /// Returns whether the motor last turned towards smaller angles behind its gear.
  bool turned_negative();

  Warmth warmth() const;

 private:
  void require_ready() const;
  void turn_to(std::int32_t shaft_target_pulses);
  /// Notes that the shaft turns from now until then.
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
  bool position_certain_;
};

/// The data of the machine that the virtual cell takes from cell.yaml, unless the truth differs.
struct VirtualHardware {
  cv::Size sensor_px{5120, 5120};
  double frame_rate_hz{15.0};
  double sense{1.0};                         ///< +1 counterclockwise, -1 clockwise
  std::array<bool, 2> relative{true, true};  ///< whether motors 2 and 3 ride on the link before
  Eigen::Vector3d pulses_per_motor_turn{10000.0, 10000.0, 10000.0};
  Eigen::Vector3d gear_ratios{100.0, 100.0, 50.0};  ///< motor turns per joint turn
  Eigen::Vector3d directions{1.0, 1.0, 1.0};        ///< each +1 or -1
  Eigen::Vector3d max_speed_rad_s{1.0, 1.0, 2.0};
  Eigen::Vector3d max_acceleration_rad_s2{5.0, 5.0, 10.0};
  Eigen::Vector3d home_rad{0.0, 0.0, 0.0};  ///< joint angles at power-up
  bool knows_position{true};                ///< at power-up
  VirtualMonuments monuments_B;

  /// Returns the signed scale of each motor's angle behind its gear.
  Eigen::Vector3d pulses_per_rad() const;
  /// Returns the motors' positions with the joints at home, whole pulses.
  Eigen::Vector3i home_pulses() const;
};

/// Returns the machine as built: by the truth where it says so, and the rest as stated. A monument
/// that the truth does not name stands where it is stated.
VirtualHardware as_built(const VirtualHardware& stated, const BuildTruth& build);

/// Returns a build that is as stated in every part.
BuildTruth build_as_stated(const VirtualHardware& stated);

}  // namespace planar
