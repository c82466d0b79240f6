#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "planar_servo/lamps/detect/blob.h"
#include "planar_servo/lamps/paper/grey_moment_edges.h"

namespace planar {

/// Returns the window of grey moments for a lamp of the blob's size.
const GreyMoments& moments_for(const Blob& blob);

/// Returns how many pixels must lie beyond a blob's box, that the windows stay in the image.
int least_margin_px(const GreyMoments& moments);

/// Returns the edge points of the lamp that a blob has announced, in pixels of the image: Canny's
/// pixels about the blob's ellipse, each moved to the edge that the grey moments find there. The
/// image is CV_8UC1, and at least least_margin_px() of its pixels lie beyond the blob's box.
std::vector<Eigen::Vector2d> canny_edges(const cv::Mat& image, const Blob& blob);

}  // namespace planar
