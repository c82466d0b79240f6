#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "planar_servo/arm/planar_arm.h"

namespace planar {

/// A motor rides on the link before it and turns by the difference (relative), or a belt or
/// parallelogram carries the absolute angle (absolute).
enum class Coupling { kRelative, kAbsolute };

/// Motor positions in pulses, joints 1 to 3.
using Pulses = Eigen::Vector3i;

/// What a motor's position is counted from: a mark that a person sets it to, or a switch that it
/// looks for by itself.
enum class HomeReference { kTaught, kReverseSwitch, kForwardSwitch };

struct MotorDrive {
  double pulses_per_motor_turn{10000.0};
  double gear_ratio{100.0};             ///< motor turns per joint turn
  int direction{1};                     ///< +1 or -1
  double max_speed_rad_s{1.0};          ///< of the joint, that is behind the gear
  double max_acceleration_rad_s2{5.0};  ///< of the joint
  HomeReference home{HomeReference::kTaught};
  double home_rad{0.0};  ///< the motor's angle behind its gear at its mark or switch
};

struct TransmissionSettings {
  std::array<Coupling, 2> coupling{Coupling::kRelative, Coupling::kRelative};  ///< motors 2 and 3
  std::array<MotorDrive, 3> drives;
  /// Lower and upper limit of each motor's angle behind its gear, radians.
  std::array<Eigen::Vector2d, 3> limits_rad;
};

/// Joint angles <-> motor angles <-> pulses: m = C theta, n = round(K m).
class Transmission {
 public:
  /// Throws std::invalid_argument for a setting that breaks its rule (zero or non-finite scale,
  /// direction not +-1, empty limits).
  explicit Transmission(const TransmissionSettings& settings);

  Eigen::Vector3d motors_from_joints(const Joints& theta) const;
  Joints joints_from_motors(const Eigen::Vector3d& motors) const;

  /// Throws std::invalid_argument for non-finite angles, std::out_of_range beyond 32-bit pulses.
  Pulses pulses_from_joints(const Joints& theta) const;
  Joints joints_from_pulses(const Pulses& pulses) const;

  /// What breaks a motor's limits at these joint angles, in words with the numbers; empty when
  /// nothing does.
  std::optional<std::string> limit_violation(const Joints& theta) const;

  /// The same pose of the arm with each motor on that turn within its limits which lies nearest its
  /// angle at `near`; empty when a motor has none.
  std::optional<Joints> branch_within_limits(const Joints& theta, const Joints& near) const;

  /// C of the equations.
  const Eigen::Matrix3d& coupling_matrix() const { return C_; }
  /// K of the equations, pulses per radian of motor angle behind the gear, signed.
  const Eigen::Vector3d& pulses_per_rad() const { return K_; }
  const TransmissionSettings& settings() const { return settings_; }

 private:
  TransmissionSettings settings_;
  Eigen::Matrix3d C_;
  Eigen::Vector3d K_;
};

}  // namespace planar
