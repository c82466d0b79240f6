#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/report/live/live_view.h"

namespace planar {

/// The view of a servo at work: one measurement of the tool and the errors of its target so far.
struct ServoView {
  std::string title;                       ///< target, step and error in one line
  bool measured{true};                     ///< if false, the title says why not
  Frame frame;                             ///< shared, not copied
  std::vector<Eigen::Vector2d> lamps_px;   ///< measured, on the sensor
  std::vector<Eigen::Vector2d> wanted_px;  ///< where the lamps belong
  std::vector<Eigen::Vector2d> errors_m;   ///< from target to end point, one per step
  double stop_below_m{0.0};                ///< the error below which the servo stops
};

/// Draws a view: the frame with the lamps (crosses) and their wanted positions (rings), the errors
/// as points about the target with a logarithmic radius, and their lengths over the steps.
ViewPlot plot_of(ServoView view);

}  // namespace planar
