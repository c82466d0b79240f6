#include "report/quiver_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/units.h"
#include "report/html_page.h"

namespace planar {
namespace {

constexpr double kPanel = 320.0;  // side of a panel in SVG units
constexpr double kTitle = 44.0;   // height above it
constexpr double kMargin = 12.0;  // between panels
constexpr double kBorder = 1.05;  // of the panel beyond what is drawn
constexpr double kFooter = 30.0;  // scale bar below

/// Half the side of the square about the base that holds every point and arrow.
double half_width_m(const std::vector<QuiverPanel>& panels, double magnification) {
  double extent = 0.0;
  for (const QuiverPanel& panel : panels) {
    if (panel.points.empty() || panel.points.size() != panel.errors.size())
      throw std::invalid_argument("a quiver panel needs as many errors as points, at least one");
    for (std::size_t i = 0; i < panel.points.size(); ++i)
      for (const double length : {0.0, magnification})
        extent =
            std::max(extent, (panel.points[i] + length * panel.errors[i]).cwiseAbs().maxCoeff());
  }
  return kBorder * extent;
}

/// From blue (small) over orange to red (at `full` and beyond).
std::string color(double length, double full) {
  const double hue = 220.0 * (1.0 - std::min(1.0, std::sqrt(length / full)));
  return fmt::format("hsl({:.0f},75%,42%)", hue);
}

class PanelPainter {
 public:
  PanelPainter(double left, double half_width, double magnification, double full)
      : left_(left),
        unit_(kPanel / (2.0 * half_width)),
        magnification_(magnification),
        full_(full) {}

  std::string paint(const QuiverPanel& panel) const {
    std::string svg =
        fmt::format("<text x=\"{:.1f}\" y=\"28\" font-size=\"15\" font-weight=\"600\">{}</text>\n",
                    left_, html_escaped(panel.title));
    svg += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"#f7f7f5\" "
        "stroke=\"#ccc\"/>\n",
        left_, kTitle, kPanel, kPanel);
    const Eigen::Vector2d base = at({0.0, 0.0});
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"#555\"/>\n", base.x(),
                       base.y());
    for (std::size_t i = 0; i < panel.points.size(); ++i)
      svg += arrow(panel.points[i], panel.errors[i]);
    return svg;
  }

 private:
  Eigen::Vector2d at(const Eigen::Vector2d& p) const {
    return {left_ + kPanel / 2.0 + unit_ * p.x(), kTitle + kPanel / 2.0 - unit_ * p.y()};
  }

  std::string arrow(const Eigen::Vector2d& p, const Eigen::Vector2d& error) const {
    const Eigen::Vector2d from = at(p), to = at(p + magnification_ * error);
    const std::string paint = color(error.norm(), full_);
    return fmt::format(
        "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" "
        "stroke-width=\"1.6\"/><circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"1.8\" fill=\"{}\"/>\n",
        from.x(), from.y(), to.x(), to.y(), paint, from.x(), from.y(), paint);
  }

  double left_, unit_, magnification_, full_;
};

}  // namespace

std::string quiver_svg(const std::vector<QuiverPanel>& panels, double magnification) {
  const double half = half_width_m(panels, magnification);
  double full = 0.0;
  for (const QuiverPanel& panel : panels)
    for (const auto& e : panel.errors) full = std::max(full, e.norm());
  const double width = static_cast<double>(panels.size()) * (kPanel + kMargin) + kMargin;
  const double height = kTitle + kPanel + kFooter;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" "
      "fill=\"#fff\"/>\n",
      width, height);
  for (std::size_t i = 0; i < panels.size(); ++i)
    svg += PanelPainter(kMargin + static_cast<double>(i) * (kPanel + kMargin), half, magnification,
                        full)
               .paint(panels[i]);
  const double bar =
      kPanel / (2.0 * half) * magnification * kMillimetre;  // one millimetre of error
  const double y = kTitle + kPanel + 18.0;
  svg += fmt::format(
      "<line x1=\"{0}\" y1=\"{1}\" x2=\"{2:.1f}\" y2=\"{1}\" stroke=\"#000\" stroke-width=\"2\"/>"
      "<text x=\"{3:.1f}\" y=\"{4}\" font-size=\"12\">1 mm of error (drawn {5:.0f} times its "
      "size)</text>\n</svg>\n",
      kMargin, y, kMargin + bar, kMargin + bar + 6.0, y + 4.0, magnification);
  return svg;
}

}  // namespace planar
