#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "planar_servo/calibration/board/board.h"
#include "planar_servo/core/error.h"

namespace planar {

/// Reads an image as 8-bit grey levels. When it cannot be read, the result is empty and a fault
/// names the file.
cv::Mat read_grey(const std::filesystem::path& file, Faults& faults);

/// Finds the board in an image whose first pixel is pixel `corner_px` of the sensor. The pixels
/// found are those of the sensor. See find_board().
BoardSight find_board_on_sensor(const cv::Mat& image, const cv::Point& corner_px,
                                const Board& board);

}  // namespace planar
