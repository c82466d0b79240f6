#pragma once

#include <limits>

#include "lamps/defective_lamp.h"
#include "support/rendered_lamp.h"

namespace planar::bench {

/// What a fit does not know beside the seven numbers that any fit of an ellipse leaves open:
/// centre, both axes with their direction (three numbers), both levels.
struct FurtherUnknowns {
  bool blur{false};
  int inside_harmonics{0};   ///< of the lamp's level round the rim, cosine and sine of each
  int outside_harmonics{0};  ///< of the background's level round the rim
  /// The fit looks only at pixels at most this far from the rim.
  double band_px{std::numeric_limits<double>::infinity()};
};

/// Least variance, mean of both axes in px^2, that an unbiased centre of this lamp can have: half
/// the trace of the centre's block of the inverse Fisher information, noise as expose() has it and
/// 1/12 for the rounding. Pixels clipped at 255 say nothing.
double cramer_rao_variance_px2(const test::RenderedLamp& lamp, double background,
                               const test::Sensor& sensor, const FurtherUnknowns& further = {});

}  // namespace planar::bench
