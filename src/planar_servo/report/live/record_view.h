#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/report/live/live_view.h"

namespace planar {

/// The state of a place that is to be recorded.
enum class PlaceMark { kToDo, kDone, kLeftOut };

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

/// Draws a map: places that are done, left and left out, the borders of the workspace, the base and
/// the monuments; x to the right, y up.
ViewPlot plot_of(RecordView view);

}  // namespace planar
