#pragma once

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

namespace planar {

/// Returns the region of the sensor that follows the lamps: a square with sides of `side_px`, cut
/// to the sensor's size and centred on `center_px` as far as it then lies on the sensor.
cv::Rect follow_region(const cv::Size& sensor_px, int side_px, const Eigen::Vector2d& center_px);

}  // namespace planar
