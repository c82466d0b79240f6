#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "planar_servo/report/panel.h"

namespace planar {

/// Errors, drawn as arrows from the points where they were found, in the base frame.
struct QuiverPanel {
  std::string title;
  std::vector<Eigen::Vector2d> points;  ///< metres
  std::vector<Eigen::Vector2d> errors;  ///< metres, as many as points
};

/// Explains the plot of quiver_svg() to a reader.
constexpr char kQuiverCaption[] =
    "Each line leads from a place into the direction of its error. The panels share axes, length "
    "of the lines and colours, so that they can be compared; the colour tells small errors whose "
    "lines are too short to be seen.";

/// Draws the errors: x to the right, y up, in millimetres. Axes, lengths of arrows and colours
/// (logarithmic) are common to all panels. Throws std::invalid_argument for panels without points
/// or with unequal numbers of points and errors.
std::vector<Panel> quiver_panels(const std::vector<QuiverPanel>& panels);

/// Draws these panels side by side as one SVG element.
std::string quiver_svg(const std::vector<QuiverPanel>& panels);

}  // namespace planar
