#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace planar {

/// Returns the exact fraction of each pixel of `window_px` that lies inside a simple closed polygon
/// (CV_32FC1, 0 to 1, of the window's size). Pixel (c, r) is the square c +- 1/2, r +- 1/2. The
/// polygon may turn either way and may leave the window. The signed areas to the right of its edges
/// are summed along the rows.
cv::Mat1f polygon_coverage(const std::vector<Eigen::Vector2d>& outline_px,
                           const cv::Rect& window_px);

/// Returns the smallest window that holds the outline with `margin_px` on each side.
cv::Rect window_around(const std::vector<Eigen::Vector2d>& outline_px, double margin_px);

}  // namespace planar
