#pragma once

#include "planar_servo/core/units.h"

namespace planar {

enum class ServoLaw { kJacobian, kInverse };

/// How the last motion of a step arrives: straight, or always from the same side of every motor, so
/// that play in the gears does not show.
enum class Approach { kDirect, kOneSide };

/// The `servo` block of a cell, in SI.
struct ServoSettings {
  ServoLaw law{ServoLaw::kJacobian};
  double gain{1.0};  ///< in (0, 1]
  double tolerance_m{5e-6};
  int max_iterations{12};  ///< corrections after the first move; 0 moves open loop and measures
  double max_step_m{5e-3};
  double settle_s{0.2};
  int frames_per_measurement{3};
  Approach approach{Approach::kOneSide};
  /// How far every motor, behind its gear, first stops short when it approaches from one side. It
  /// must exceed the play; 0.2 deg is several times that of a gear fit for positioning.
  double approach_margin_rad{0.2 * kDegree};
};

}  // namespace planar
