#pragma once

#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// A gear with play and eccentric wheels, between the motor's angle (over the gear ratio) and the
/// angle that really comes out.
class Reducer {
 public:
  /// The play stands in its middle.
  Reducer(const ReducerTruth& truth, double motor_rad) : truth_(truth), held_rad_(motor_rad) {}

  /// The motor moved to this angle without turning back on the way: the play operator.
  void follow(double motor_rad);

  /// The angle behind the gear, zero offset included.
  double output_rad() const;

 private:
  ReducerTruth truth_;
  double held_rad_;  ///< the motor's angle less its place in the play
};

}  // namespace planar
