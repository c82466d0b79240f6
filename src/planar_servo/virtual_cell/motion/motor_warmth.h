#pragma once

#include "planar_servo/virtual_cell/truth/arm_truth.h"

namespace planar {

/// How warm a motor and what it warms are. 0 is cold, 1 as after an hour of regular work from cold,
/// in which the motor turns for 30 % of the time.
struct Warmth {
  double motor{0.0};
  double link{0.0};
};

/// The heat of a motor that turns or is held at rest, with the link that it warms. The motor
/// follows its heating with one time constant, the link follows the motor with another.
class MotorWarmth {
 public:
  explicit MotorWarmth(const ArmWarmingTruth& truth);

  /// From `t_s` on the motor turns until `turns_until_s`; then it is held, if it is energized.
  void work(double t_s, double turns_until_s, bool energized);

  /// Asking changes nothing. Times do not go back.
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

}  // namespace planar
