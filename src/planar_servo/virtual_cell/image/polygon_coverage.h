#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace planar {

/// The part of each pixel of `window_px` that lies inside a simple closed polygon, exactly (0..1,
/// CV_32FC1 of the window's size); pixel (c, r) is the square c +- 1/2, r +- 1/2. The polygon may
/// leave the window. Either sense of rotation. Accumulates the signed area to the right of each
/// edge, then sums along the rows.
cv::Mat1f polygon_coverage(const std::vector<Eigen::Vector2d>& outline_px,
                           const cv::Rect& window_px);

/// The least window that holds the outline and `margin_px` more on each side.
cv::Rect window_around(const std::vector<Eigen::Vector2d>& outline_px, double margin_px);

}  // namespace planar
