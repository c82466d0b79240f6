#pragma once

#include "planar_servo/lamps/rim/rim_band.h"

namespace planar {

/// The light of a blurred straight edge at x standard deviations outside it: its share of the full
/// light, and minus the slope of that share.
struct EdgeShape {
  double share, density;
};
EdgeShape edge_shape(double x);

/// Grey levels across a rim at the distance d outside it: a step blurred by a Gaussian between two
/// lines, dark + dark_slope d outside and bright + bright_slope d inside.
struct EdgeProfile {
  double dark{0.0}, bright{0.0}, dark_slope{0.0}, bright_slope{0.0};
  double offset_px{0.0};  ///< of the step
  double blur_px{0.9};    ///< standard deviation

  EdgeShape shape(double d) const { return edge_shape((d - offset_px) / blur_px); }
};

/// Fits the profile to levels at distances, from `start`. A weight is the inverse variance of a
/// level, or 0. Parameters that the levels do not determine, such as the bright side of a clipped
/// lamp, stay near `start`.
EdgeProfile fit_edge_profile(const RimBand::Places& distance_px, const RimBand::Places& level,
                             const RimBand::Places& weight, const EdgeProfile& start);

}  // namespace planar
