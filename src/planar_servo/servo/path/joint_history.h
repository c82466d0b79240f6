#pragma once

#include <deque>

#include "planar_servo/arm/planar_arm.h"

namespace planar {

/// Remembers for a while where the drives stood when, so that a picture is held against the joints
/// at its exposure.
class JointHistory {
 public:
  /// Takes the joints at a time that is not before those taken already, seconds.
  void add(double t_s, const Joints& theta);

  /// Returns the joints at a time, straight between two that were taken; before the first and after
  /// the last one, those. Throws std::logic_error when none was taken.
  Joints at(double t_s) const;

 private:
  struct Sample {
    double t_s;
    Joints theta;
  };
  std::deque<Sample> samples_;
};

}  // namespace planar
