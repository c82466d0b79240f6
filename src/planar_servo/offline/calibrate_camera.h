#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/calibration/camera_calibration.h"
#include "planar_servo/offline/grey_image.h"

namespace planar {

/// Reads an image as 8-bit grey levels. When it cannot be read, the result is empty and a fault
/// names the file.
cv::Mat read_grey(const PictureSet& set, const std::filesystem::path& file, Faults& faults);

/// Finds the board in an image whose first pixel is pixel `corner_px` of the sensor. The pixels
/// found are those of the sensor. See find_board().
BoardSight find_board_on_sensor(const cv::Mat& image, const cv::Point& corner_px,
                                const Board& board, BoardPart part = BoardPart::kWhole);

/// Holds what the pictures of a board gave for a calibration.
struct BoardViews {
  CalibrationProblem problem;
  std::vector<Rejection> rejected;            ///< pictures without the board
  std::vector<std::filesystem::path> inputs;  ///< the pictures and the tables that list them
};

/// Finds the board in each image. A recording's folder stands for its frames of plan `grid`, whose
/// regions are put back in their place on the sensor. An image of another size than the first is
/// rejected by name. Throws InputError naming each file that cannot be read as an image.
BoardViews find_board_views(const std::vector<std::filesystem::path>& images, const Board& board);

/// Reads views of the board from a file of pixels that another program found, view after view; see
/// read_board_pixels(). The images have the given size. When it is empty, the size is chosen such
/// that the points lie within the image. Throws InputError unless the points make whole views.
BoardViews board_views_from_points(const std::filesystem::path& points, const Board& board,
                                   cv::Size size_px);

}  // namespace planar
