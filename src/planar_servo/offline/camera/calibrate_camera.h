#pragma once

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <vector>

#include "planar_servo/calibration/board/board.h"
#include "planar_servo/calibration/camera_calibration.h"

namespace planar {

/// What the pictures of a board gave for a calibration.
struct BoardViews {
  CalibrationProblem problem;
  std::vector<RejectedView> rejected;         ///< pictures without the whole board
  std::vector<std::filesystem::path> inputs;  ///< the pictures and the tables that list them
};

/// Finds the board in each image. A recording's folder stands for its frames of plan `grid`, whose
/// regions are put back in their place on the sensor. Throws InputError naming each file that
/// cannot be read as an image; an image of another size than the first is rejected by name.
BoardViews find_board_views(const std::vector<std::filesystem::path>& images, const Board& board);

/// Views of the board from pixels that another program found, view after view (see
/// read_board_pixels), in images of the given size; an empty size is taken such that the points lie
/// amid the image. Throws InputError unless they make whole views.
BoardViews board_views_from_points(const std::filesystem::path& points, const Board& board,
                                   cv::Size size_px);

}  // namespace planar
