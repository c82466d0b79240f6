#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace planar {

/// Errors drawn as arrows from the points where they were found, in the base frame.
struct QuiverPanel {
  std::string title;
  std::vector<Eigen::Vector2d> points;  ///< metres
  std::vector<Eigen::Vector2d> errors;  ///< metres, as many as points
};

/// What a reader needs to know of quiver_svg().
constexpr char kQuiverCaption[] =
    "Each line leads from a place into the direction of its error, as long as the bar below its "
    "panel says; a colour is the same size of error in all panels. The grey disc is the base, x "
    "points to the right, y up.";

/// The panels side by side as one SVG element: x to the right, y up, the base in the middle. Places
/// and colours, which tell the length of an error, have one scale for all panels; arrows are as
/// long as suits their panel, and a bar below it tells their scale, beside the width of the field.
/// Throws std::invalid_argument for panels without points or of unequal sizes.
std::string quiver_svg(const std::vector<QuiverPanel>& panels);

}  // namespace planar
