#pragma once

#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// A gear with all that is wrong with it and its motor, between the motor's angle (divided by the
/// gear ratio) and the angle that comes out.
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
  /// Winds the gear up by the friction of a turn: Dahl's model of it without a load.
  void wind(double turn_rad);

  ReducerTruth truth_;
  double gear_ratio_;
  double motor_rad_;
  double held_rad_;  ///< the angle on the far side of the play
  double wound_rad_{0.0};
  bool turned_negative_{false};
};

}  // namespace planar
