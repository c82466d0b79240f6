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

/// The centre of gravity of a blob's light, counted from 20 % to 80 % of the contrast, so that
/// neither the noise inside nor the one outside moves it. Exact for a disc that is evenly bright on
/// a dark ground, wrong by what else there is. The covariance is that of the rim's pixels at the
/// noise that their levels have beside the rim. Empty without light.
std::optional<LightCentroid> light_centroid(const cv::Mat& image, const Blob& blob);

}  // namespace planar
