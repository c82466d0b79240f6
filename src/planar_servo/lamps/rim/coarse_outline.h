#pragma once

#include <Eigen/Core>
#include <optional>

#include "planar_servo/lamps/blob.h"
#include "planar_servo/lamps/rim/outline.h"
#include "planar_servo/lamps/rim/pixel_noise.h"
#include "planar_servo/lamps/rim/rim_band.h"

namespace planar {

/// An outline through half-level edges, correct to a few tenths of a pixel.
struct CoarseOutline {
  Outline outline;
  NormalFlags use;                    ///< the normals whose edges belong to it
  Eigen::Matrix2d center_covariance;  ///< from the scatter of the edges
};

/// What half-level edges can be. They cannot tell a covered rim from a bent one that is unevenly
/// lit.
struct CoarseOutlines {
  CoarseOutline likely;
  std::optional<CoarseOutline> bent;  ///< through all edges, where `likely` leaves some out
};

/// Fits outlines to the half-level edges in a band that was sampled along `from`. The first one
/// that explains them is likely: an ellipse, then an ellipse with large waves. If neither does, an
/// outline with ordinary waves is fitted to all but a quarter of the rim and to what agrees with
/// that; it is likely if its residuals are clearly smaller than those of the one with large waves.
/// Empty when less than half of the rim has edges.
std::optional<CoarseOutlines> find_outlines(const RimBand& band, const Outline& from,
                                            const Blob& blob, const PixelNoise& noise);

}  // namespace planar
