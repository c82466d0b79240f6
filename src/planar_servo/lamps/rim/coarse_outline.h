#pragma once

#include <Eigen/Core>
#include <optional>

#include "planar_servo/lamps/detect/blob.h"
#include "planar_servo/lamps/rim/outline.h"
#include "planar_servo/lamps/rim/pixel_noise.h"
#include "planar_servo/lamps/rim/rim_band.h"

namespace planar {

/// An outline through half-level edges, within a few tenths of a pixel.
struct CoarseOutline {
  Outline outline;
  NormalFlags use;                    ///< the normals whose edges belong to it
  Eigen::Matrix2d center_covariance;  ///< by the scatter of the edges
};

/// From the outline that a band was sampled along to the first that explains the edges in it: an
/// ellipse, one with waves as large as they come, and one with ordinary waves through all but a
/// quarter of the rim and through what agrees with that; the last only if it leaves clearly less
/// than the one before. Empty when less than half of the rim has edges.
std::optional<CoarseOutline> find_outline(const RimBand& band, const Outline& from,
                                          const Blob& blob, const PixelNoise& noise);

}  // namespace planar
