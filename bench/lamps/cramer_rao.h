#pragma once

#include <limits>

#include "lamps/defective_lamp.h"
#include "support/rendered_lamp.h"

namespace planar::bench {

/// Says what a fit does not know beside the seven numbers that any fit of an ellipse leaves open:
/// the centre, both axes with their direction (three numbers), and both levels.
struct FurtherUnknowns {
  bool blur{false};
  int inside_harmonics{0};   ///< harmonics of the lamp's level round the rim (cosine and sine)
  int outside_harmonics{0};  ///< harmonics of the background's level round the rim
  /// The fit looks only at pixels that lie at most this far from the rim.
  double band_px{std::numeric_limits<double>::infinity()};
};

/// Returns the least variance (mean of both axes, px^2) that an unbiased centre of this lamp can
/// have: half the trace of the centre's block of the inverse Fisher information. The noise is that
/// of expose(), plus 1/12 for the rounding. Pixels clipped at 255 carry no information.
double cramer_rao_variance_px2(const test::RenderedLamp& lamp, double background,
                               const test::Sensor& sensor, const FurtherUnknowns& further = {});

}  // namespace planar::bench
