#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/purpose.h"
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

/// A recording on its way, seen from above: base frame, metres.
struct RecordView {
  struct Circle {
    Eigen::Vector2d p_B;
    double radius_m;
  };
  struct Place {
    Eigen::Vector2d p_B;
    PlaceMark mark;
  };
  struct Point {
    std::string id;
    Eigen::Vector2d p_B;
  };

  std::string title;                ///< how far it has come
  std::string now;                  ///< what is recorded now
  std::vector<std::string> counts;  ///< beside the map
  std::vector<Circle> borders;      ///< of the workspace
  std::vector<Point> monuments;
  std::vector<Place> places;
  std::optional<Eigen::Vector2d> here_B;  ///< the place that is recorded now
};

/// Draws a map of places, the borders of the workspace, base and monuments; x to the right, y up.
ViewPlot plot_of(RecordView view);

}  // namespace planar
