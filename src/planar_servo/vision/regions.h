#pragma once

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

#include "planar_servo/files/cell_file.h"

namespace planar {

/// The region of the sensor that follows the lamps: of the cell's size, about a pixel, moved to lie
/// on the sensor.
cv::Rect follow_region(const CameraSettings& camera, const Eigen::Vector2d& center_px);

}  // namespace planar
