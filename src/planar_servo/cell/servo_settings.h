#pragma once

#include "planar_servo/core/units.h"

namespace planar {

/// Names the control law that turns a measured error into a joint step; see control_law.h.
enum class ServoLaw { kJacobian, kInverse };

/// Says how the last motion of a step arrives: straight, or always from the same side of every
/// motor, so that play in the gears does not show.
enum class Approach { kDirect, kOneSide };

/// Holds the `servo` block of a cell, in SI units.
struct ServoSettings {
  ServoLaw law{ServoLaw::kJacobian};
  double gain{1.0};  ///< in (0, 1]
  double tolerance_m{5e-6};
  double orientation_tolerance{0.2 * kDegree};  ///< of the tool's direction, radians
  int max_iterations{12};  ///< corrections after the first move; with 0 it only measures
  double max_step_m{5e-3};
  double settle_s{0.2};
  int frames_per_measurement{3};
  bool learns{true};  ///< the arm, from looks at its targets, where it was found with its field
  Approach approach{Approach::kOneSide};
  /// The angle by which every motor, behind its gear, first stops short when it approaches from one
  /// side. It must exceed the play; 0.2 deg is several times that of a gear fit for positioning.
  double approach_margin_rad{0.2 * kDegree};
};

}  // namespace planar
