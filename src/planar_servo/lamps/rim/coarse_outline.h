#pragma once

#include <Eigen/Core>
#include <optional>

#include "planar_servo/lamps/detect/blob.h"
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

/// Fits outlines to the half-level edges in a band that was sampled along `from`, and returns the
/// first one that explains them: an ellipse, then an ellipse with large waves. If neither does, an
/// outline with ordinary waves is fitted to all but a quarter of the rim and to what agrees with
/// that; it is returned if its residuals are clearly smaller, else the one with large waves. Empty
/// when less than half of the rim has edges.
std::optional<CoarseOutline> find_outline(const RimBand& band, const Outline& from,
                                          const Blob& blob, const PixelNoise& noise);

}  // namespace planar
