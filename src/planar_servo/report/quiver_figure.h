#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace planar {

/// Errors, drawn as arrows from the points where they were found, in the base frame.
struct QuiverPanel {
  std::string title;
  std::vector<Eigen::Vector2d> points;  ///< metres
  std::vector<Eigen::Vector2d> errors;  ///< metres, as many as points
};

/// Explains the figure of quiver_svg() to a reader.
constexpr char kQuiverCaption[] =
    "Each line leads from a place into the direction of its error, as long as the bar below its "
    "panel says; a colour is the same size of error in all panels. The grey disc is the base, x "
    "points to the right, y up.";

/// Draws the panels side by side as one SVG element: x to the right, y up, the base in the middle.
/// Positions have one scale in all panels, and a colour means one length of error. Arrows have a
/// scale per panel, shown by the bar below it, next to the width of the field. Throws
/// std::invalid_argument for panels without points or with unequal numbers of points and errors.
std::string quiver_svg(const std::vector<QuiverPanel>& panels);

}  // namespace planar
