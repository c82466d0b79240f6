#pragma once

#include "planar_servo/lamps/rim/rim_band.h"

namespace planar {

/// Share of the light of a blurred straight edge at x standard deviations outside it, and minus its
/// slope.
struct EdgeShape {
  double share, density;
};
EdgeShape edge_shape(double x);

/// Grey levels across a rim at the distance d from it, outwards: a step blurred by a Gaussian
/// between two lines, dark + dark_slope d outside and bright + bright_slope d inside.
struct EdgeProfile {
  double dark{0.0}, bright{0.0}, dark_slope{0.0}, bright_slope{0.0};
  double offset_px{0.0};  ///< of the step
  double blur_px{0.9};    ///< standard deviation

  EdgeShape shape(double d) const { return edge_shape((d - offset_px) / blur_px); }
};

/// Fits levels at distances; a weight is the inverse of the level's variance, or 0. `start` gives
/// the levels to begin with. What the levels do not tell (the bright side of a clipped lamp) stays
/// near the start.
EdgeProfile fit_edge_profile(const RimBand::Places& distance_px, const RimBand::Places& level,
                             const RimBand::Places& weight, const EdgeProfile& start);

}  // namespace planar
