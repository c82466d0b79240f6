#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "planar_servo/devices/frame.h"

namespace planar {

/// What a person wants to see of a servo at work: one look at the tool, and how the errors of its
/// target came down.
struct ServoView {
  std::string title;                       ///< target, step, error, in a line
  bool measured{true};                     ///< false: the title says why not
  Frame frame;                             ///< shared, not copied
  std::vector<Eigen::Vector2d> lamps_px;   ///< measured, on the sensor
  std::vector<Eigen::Vector2d> wanted_px;  ///< where the lamps belong
  std::vector<Eigen::Vector2d> errors_m;   ///< from target to end point, one per step
  double stop_below_m{0.0};                ///< error at which the servo is content
};

}  // namespace planar
