#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "planar_servo/report/live/live_view.h"

namespace planar {

/// The view for a person who holds the calibration board before the camera.
struct BoardView {
  std::string title;                        ///< how many views are still to be taken
  std::string state;                        ///< of the board now
  bool good{false};                         ///< the state is one in which a view is taken
  std::string wish;                         ///< what the next view should show
  std::vector<std::string> lacks;           ///< what no view has shown so far
  cv::Mat picture;                          ///< the whole sensor, CV_8UC1; shared, not copied
  std::vector<Eigen::Vector2d> dots_px;     ///< seen now
  std::vector<cv::Rect2d> open_px;          ///< where a view should reach to
  std::vector<Eigen::Vector2d> covered_px;  ///< of the views taken
};

/// Draws a view: the picture with the dots seen (green, or orange while they move), those of the
/// views taken (blue) and frames where a view should reach to, and the texts beside it.
ViewPlot plot_of(BoardView view);

}  // namespace planar
