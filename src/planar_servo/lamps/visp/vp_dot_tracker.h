#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "planar_servo/lamps/detect/blob.h"

namespace planar {

/// A blob as ViSP's vpDot2 sees it.
struct VpDot {
  Eigen::Vector2d center_px{0.0, 0.0};  ///< vpDot2's own: moments of a contour of whole pixels
  Blob blob;
};

/// The blob of pixels of at least `least_level` that covers `seed_px`, followed along its contour
/// by vpDot2 inside a window (cut to the image). Coordinates of the whole image. Empty when the
/// seed is not on such a blob.
std::optional<VpDot> vp_dot(const cv::Mat& image, const cv::Rect& window_px,
                            const Eigen::Vector2d& seed_px, int least_level);

/// The square of this half side round a pixel.
cv::Rect window_round(const Eigen::Vector2d& uv_px, double half_side_px);

}  // namespace planar
