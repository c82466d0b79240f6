#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "planar_servo/calibration/board/board.h"
#include "planar_servo/core/error.h"

namespace planar {

/// An image as 8-bit grey levels; when it cannot be read it is empty, and a fault names it.
cv::Mat read_grey(const std::filesystem::path& file, Faults& faults);

/// find_board() for an image whose first pixel is `corner_px` of the sensor: the pixels found are
/// those of the sensor.
BoardSight find_board_on_sensor(const cv::Mat& image, const cv::Point& corner_px,
                                const Board& board);

}  // namespace planar
