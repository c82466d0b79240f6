#include "planar_servo/report/quiver_plot.h"

#include <stdexcept>

#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"

namespace planar {
std::vector<Panel> quiver_panels(const std::vector<QuiverPanel>& panels) {
  std::vector<Eigen::Vector2d> all_points, all_errors;
  for (const QuiverPanel& panel : panels) {
    if (panel.points.empty() || panel.points.size() != panel.errors.size())
      throw std::invalid_argument("a quiver panel needs as many errors as points, at least one");
    for (const Eigen::Vector2d& p : in_mm(panel.points)) all_points.push_back(p);
    for (const Eigen::Vector2d& error : in_mm(panel.errors)) all_errors.push_back(error);
  }
  const FieldAxes axes = axes_over_places(all_points);
  const ArrowScale arrows = arrows_over(all_errors, "mm");
  const ColorScale colors("error, mm", lengths_of(all_errors), ColorScale::Steps::kDecades);
  std::vector<Panel> drawn;
  for (const QuiverPanel& panel : panels) {
    const std::vector<Eigen::Vector2d> errors = in_mm(panel.errors);
    drawn.emplace_back(panel.title, axes.x, axes.y, Panel::Aspect::kEqual);
    drawn.back().add_arrows(in_mm(panel.points), errors, arrows, {"", &colors, lengths_of(errors)});
  }
  drawn.back().add_color_bar(colors);
  return drawn;
}

std::string quiver_svg(const std::vector<QuiverPanel>& panels) {
  return plot_svg(quiver_panels(panels));
}

}  // namespace planar
