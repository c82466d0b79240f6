#pragma once

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

namespace planar {

/// The square region of the sensor that follows the lamps: `side_px` on a side, cut to the sensor's
/// size, with `center_px` in its middle as far as it can lie on the sensor.
cv::Rect follow_region(const cv::Size& sensor_px, int side_px, const Eigen::Vector2d& center_px);

}  // namespace planar
