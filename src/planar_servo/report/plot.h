#pragma once

#include <string>
#include <vector>

#include "planar_servo/report/panel.h"

namespace planar {

/// Draws the panels side by side as one SVG element that needs nothing from outside.
std::string plot_svg(const std::vector<Panel>& panels);

/// Draws vectors' components over a number for each vector, x in blue and y in orange, with a line
/// at zero.
Panel component_panel(const std::string& title, const Axis& over, const Axis& components,
                      const std::vector<double>& at, const std::vector<Eigen::Vector2d>& vectors);

/// A normal curve about zero to compare a histogram with.
struct NormalCurve {
  double sigma{1.0};
  std::string what;  ///< "their rms", "the stated deviation"
};

/// Draws how often values occur, in bars of a round width, with a normal curve of the same area.
/// Values beyond six robust deviations are counted in a note. Throws std::invalid_argument for no
/// values.
Panel histogram(const std::string& title, const std::string& label,
                const std::vector<double>& values, const NormalCurve& expected);

}  // namespace planar
