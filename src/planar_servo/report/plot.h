#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "planar_servo/report/panel.h"

namespace planar {

/// Draws the panels side by side as one SVG element that needs nothing from outside. What it shows
/// is said in words, too, for readers who cannot see it.
std::string plot_svg(const std::vector<Panel>& panels);

/// Draws the panels for a page: an SVG element each, side by side or, if too wide, in a column.
std::string plot_html(const std::vector<Panel>& panels);

/// Draws vectors' components over a number for each vector, as two series, with a line at zero.
Panel component_panel(const std::string& title, const Axis& over, const Axis& components,
                      const std::vector<double>& at, const std::vector<Eigen::Vector2d>& vectors);

/// A normal curve about zero to compare a histogram with.
struct NormalCurve {
  double sigma{1.0};
  std::string what;  ///< "their rms", "the stated deviation"
};

/// Draws how often values occur, in bars of a round width, with a normal curve of the same area. A
/// note counts values beyond six robust deviations. Throws std::invalid_argument for no values.
Panel histogram(const std::string& title, const std::string& label,
                const std::vector<double>& values, const NormalCurve& expected);

/// Errors, drawn as arrows from the points where they were found, in the base frame.
struct QuiverPanel {
  std::string title;
  std::vector<Eigen::Vector2d> points;  ///< metres
  std::vector<Eigen::Vector2d> errors;  ///< metres, as many as points
};

constexpr char kQuiverCaption[] =
    "Each line leads from a place into the direction of its error. The panels share axes, length "
    "of the lines and colours, so that they can be compared; the colour shows errors whose lines "
    "are too short to be seen.";

/// Draws the errors: x to the right, y up, in millimetres. Axes, lengths of arrows and colours
/// (logarithmic) are common to all panels. Throws std::invalid_argument for panels without points
/// or with unequal numbers of points and errors.
std::vector<Panel> quiver_panels(const std::vector<QuiverPanel>& panels);

}  // namespace planar
