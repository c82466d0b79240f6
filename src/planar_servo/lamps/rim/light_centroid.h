#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "planar_servo/lamps/detect/blob.h"

namespace planar {

struct LightCentroid {
  Eigen::Vector2d center{0.0, 0.0};
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};
};

/// Returns the centre of gravity of a blob's light. Light counts from 20 % to 80 % of the contrast,
/// so that noise inside and outside does not move it. It is exact for an evenly bright disc on a
/// dark ground and biased by all other light. The covariance is that of the noise of the rim's
/// pixels. Empty without light.
std::optional<LightCentroid> light_centroid(const cv::Mat& image, const Blob& blob);

}  // namespace planar
