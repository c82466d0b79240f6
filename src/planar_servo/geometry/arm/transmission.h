#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/geometry/arm/planar_arm.h"

namespace planar {

/// How a motor's angle depends on the joint angles. A relative motor rides on the link before it
/// and turns by the difference of two joint angles. An absolute motor turns by its own joint's
/// angle, through a belt or parallelogram.
enum class Coupling { kRelative, kAbsolute };

/// Positions of motors 1 to 3, pulses.
using Pulses = Eigen::Vector3i;

/// The place from which a motor's position is counted: a mark that a person moves it to, a switch
/// that it seeks itself, or where the camera sees it.
enum class HomeReference { kTaught, kReverseSwitch, kForwardSwitch, kSight };

inline bool is_switch(HomeReference home) {
  return home == HomeReference::kReverseSwitch || home == HomeReference::kForwardSwitch;
}

struct MotorDrive {
  double pulses_per_motor_turn{10000.0};
  double gear_ratio{100.0};             ///< motor turns per joint turn
  int direction{1};                     ///< +1 or -1
  double max_speed_rad_s{1.0};          ///< of the joint, behind the gear
  double max_acceleration_rad_s2{5.0};  ///< of the joint
  HomeReference home{HomeReference::kTaught};
  double home_rad{0.0};  ///< the motor's angle, behind its gear, at its mark or switch
};

struct TransmissionSettings {
  std::array<Coupling, 2> coupling{Coupling::kRelative, Coupling::kRelative};  ///< motors 2 and 3
  std::array<MotorDrive, 3> drives;
  /// Whether all motors take the same time for a move, so that their angles change in one straight
  /// line. Else each makes its own MotorMove.
  bool moves_straight{false};
  /// Lower and upper limit of each motor's angle behind its gear, radians.
  std::array<Eigen::Vector2d, 3> limits_rad{Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.0, 0.0),
                                            Eigen::Vector2d(0.0, 0.0)};
};

/// Converts between joint angles theta, motor angles m and pulses n: m = C theta, n = round(K m).
/// Motor angles are those behind the gear, radians.
class Transmission {
 public:
  /// Throws std::invalid_argument for a scale that is zero or not finite, a direction other than
  /// +-1 or limits that leave no angle.
  explicit Transmission(const TransmissionSettings& settings);

  Eigen::Vector3d motors_from_joints(const Joints& theta) const;
  Joints joints_from_motors(const Eigen::Vector3d& motors) const;

  /// Throws std::invalid_argument for angles that are not finite and std::out_of_range for pulses
  /// beyond 32 bits.
  Pulses pulses_from_joints(const Joints& theta) const;
  Joints joints_from_pulses(const Pulses& pulses) const;

  /// Names the motor's limit that these joint angles break, in words with the numbers; empty when
  /// they break none.
  std::optional<std::string> limit_violation(const Joints& theta) const;

  /// The margin between a motor and its limits, radians.
  struct Room {
    double below{0.0}, above{0.0};
  };

  /// Returns the same pose with each motor on the turn within its limits, with at least `room`,
  /// that lies nearest to its angle at `near`; empty when a motor has no such turn.
  std::optional<Joints> branch_within_limits(const Joints& theta, const Joints& near,
                                             const Room& room) const;

  /// Returns how long the slowest motor takes between these motor angles, each in a MotorMove, s.
  /// Throws std::invalid_argument for angles that are not finite.
  double longest_move_s(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;

  /// Returns C of the equations.
  const Eigen::Matrix3d& coupling_matrix() const { return C_; }
  /// Returns K of the equations, signed, in pulses per radian of motor angle.
  const Eigen::Vector3d& pulses_per_rad() const { return K_; }
  const TransmissionSettings& settings() const { return settings_; }
  /// Returns the motors' limits of speed and acceleration, in pulses.
  std::array<DriveLimits, 3> rated_limits() const;

 private:
  TransmissionSettings settings_;
  Eigen::Matrix3d C_;
  Eigen::Vector3d K_;
};

/// How fast a straight move may be: parts of its way per second, and per second squared.
struct StraightPace {
  double speed{0.0}, acceleration{0.0};
};

/// Returns the fastest pace of a straight way at which no motor exceeds its own speed and
/// acceleration, which are in the units of the way; infinite where there is no way.
StraightPace straight_pace(const Eigen::Vector3d& way, const Eigen::Vector3d& speeds,
                           const Eigen::Vector3d& accelerations);

/// A motor's move from rest to rest as its drive makes it: at its full acceleration to its full
/// speed, and back to rest; a short one never reaches that speed. Radians behind the gear.
class MotorMove {
 public:
  /// Throws std::invalid_argument for angles that are not finite.
  MotorMove(double from_rad, double to_rad, const MotorDrive& drive);

  double duration_s() const { return 2.0 * ramp_s_ + cruise_s_; }

  /// Returns the angle at this time after the beginning; at rest before and afterwards.
  double angle_at(double t_s) const;
  /// Returns its speed at that time, radians/s, signed.
  double speed_at(double t_s) const;

 private:
  double from_, to_;
  double acceleration_;  ///< towards the end, signed
  double ramp_s_, cruise_s_;
};

}  // namespace planar
