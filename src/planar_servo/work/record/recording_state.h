#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/base/core/purpose.h"

namespace planar {

/// A recording on its way, seen from above: base frame, metres.
struct RecordingState {
  struct Place {
    Eigen::Vector2d p_B;
    PlaceMark mark;
  };
  std::string title;                ///< how far it has come
  std::string now;                  ///< what is recorded now
  std::vector<std::string> counts;  ///< beside the map
  std::vector<Place> places;
  std::vector<std::pair<std::string, Eigen::Vector2d>> monuments;
  std::optional<Eigen::Vector2d> here_B;  ///< the place that is recorded now
};

}  // namespace planar
