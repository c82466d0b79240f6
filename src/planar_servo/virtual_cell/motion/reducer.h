#pragma once

#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// A gear with play and eccentric wheels, between the motor's angle (divided by the gear ratio) and
/// the angle that comes out.
class Reducer {
 public:
  /// Starts in the middle of the play.
  Reducer(const ReducerTruth& truth, double motor_rad) : truth_(truth), held_rad_(motor_rad) {}

  /// Follows the motor to this angle, which it reached without turning back (the play operator).
  void follow(double motor_rad);

  /// Returns the angle behind the gear, with its zero offset.
  double output_rad() const;

 private:
  ReducerTruth truth_;
  double held_rad_;  ///< the angle on the far side of the play
};

}  // namespace planar
