#include "planar_servo/report/quiver_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "planar_servo/core/units.h"
#include "planar_servo/report/html_page.h"

namespace planar {
namespace {

constexpr double kPanel = 320.0;    // side of a panel in SVG units
constexpr double kTitle = 44.0;     // height above a panel
constexpr double kMargin = 12.0;    // between panels
constexpr double kFooter = 34.0;    // height of the scale bar below
constexpr double kArrow = 36.0;     // length of a panel's longest arrow
constexpr double kLongestBar = 60;  // longest scale bar

double longest_error(const QuiverPanel& panel) {
  double longest = 0.0;
  for (const Eigen::Vector2d& error : panel.errors) longest = std::max(longest, error.norm());
  return longest;
}

/// Returns the SVG units per metre at which every point and the longest arrow at it lie in its
/// panel.
double units_per_metre(const std::vector<QuiverPanel>& panels) {
  double extent = 0.0;
  for (const QuiverPanel& panel : panels) {
    if (panel.points.empty() || panel.points.size() != panel.errors.size())
      throw std::invalid_argument("a quiver panel needs as many errors as points, at least one");
    for (const Eigen::Vector2d& p : panel.points)
      extent = std::max(extent, p.cwiseAbs().maxCoeff());
  }
  return extent > 0.0 ? (kPanel / 2.0 - kArrow) / extent : 1.0;
}

/// Returns the longest length not above `most` that is 1, 2 or 5 times a power of ten.
double round_length(double most) {
  const double decade = std::pow(10.0, std::floor(std::log10(most)));
  const double digits = most / decade;
  return decade * (digits >= 5.0 ? 5.0 : digits >= 2.0 ? 2.0 : 1.0);
}

/// Returns a colour from blue (small) over orange to red (at `full` and beyond).
std::string color(double length, double full) {
  const double share = full > 0.0 ? std::min(1.0, std::sqrt(length / full)) : 0.0;
  const double hue = 220.0 * (1.0 - share);
  return fmt::format("hsl({:.0f},75%,42%)", hue);
}

class PanelPainter {
 public:
  /// `full` is the error drawn in the deepest red.
  PanelPainter(const QuiverPanel& panel, double left, double unit, double full)
      : panel_(panel), left_(left), unit_(unit), full_(full), longest_(longest_error(panel)) {}

  std::string paint() const {
    std::string svg =
        fmt::format("<text x=\"{:.1f}\" y=\"28\" font-size=\"15\" font-weight=\"600\">{}</text>\n",
                    left_, html_escaped(panel_.title));
    svg += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"#f7f7f5\" "
        "stroke=\"#ccc\"/>\n",
        left_, kTitle, kPanel, kPanel);
    const Eigen::Vector2d base = at({0.0, 0.0});
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"#555\"/>\n", base.x(),
                       base.y());
    for (std::size_t i = 0; i < panel_.points.size(); ++i)
      svg += arrow(panel_.points[i], panel_.errors[i]);
    return svg + scale_bar() + extent();
  }

 private:
  Eigen::Vector2d at(const Eigen::Vector2d& p) const {
    return {left_ + kPanel / 2.0 + unit_ * p.x(), kTitle + kPanel / 2.0 - unit_ * p.y()};
  }

  std::string arrow(const Eigen::Vector2d& p, const Eigen::Vector2d& error) const {
    const Eigen::Vector2d from = at(p);
    const Eigen::Vector2d along =
        longest_ > 0.0 ? Eigen::Vector2d(kArrow / longest_ * error) : Eigen::Vector2d(0.0, 0.0);
    const std::string paint = color(error.norm(), full_);
    return fmt::format(
        "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" "
        "stroke-width=\"1.6\"/><circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"1.8\" fill=\"{}\"/>\n",
        from.x(), from.y(), from.x() + along.x(), from.y() - along.y(), paint, from.x(), from.y(),
        paint);
  }

  std::string extent() const {
    return fmt::format(
        "<text x=\"{:.1f}\" y=\"{}\" font-size=\"13\" fill=\"#555\" text-anchor=\"end\">{:.0f} mm "
        "wide</text>\n",
        left_ + kPanel, kTitle + kPanel + 22.0, kPanel / unit_ / kMillimetre);
  }

  std::string scale_bar() const {
    if (!(longest_ > 0.0)) return "";
    const double bar = round_length(longest_ * kLongestBar / kArrow);
    const double end = left_ + kArrow / longest_ * bar;
    const double y = kTitle + kPanel + 18.0;
    return fmt::format(
        "<line x1=\"{0:.1f}\" y1=\"{1}\" x2=\"{2:.1f}\" y2=\"{1}\" stroke=\"#000\" "
        "stroke-width=\"2\"/><text x=\"{3:.1f}\" y=\"{4}\" font-size=\"13\">{5:g} mm of "
        "error</text>\n",
        left_, y, end, end + 6.0, y + 4.0, bar / kMillimetre);
  }

  const QuiverPanel& panel_;
  double left_, unit_, full_, longest_;
};

}  // namespace

std::string quiver_svg(const std::vector<QuiverPanel>& panels) {
  const double unit = units_per_metre(panels);
  double full = 0.0;
  for (const QuiverPanel& panel : panels) full = std::max(full, longest_error(panel));
  const double width = static_cast<double>(panels.size()) * (kPanel + kMargin) + kMargin;
  const double height = kTitle + kPanel + kFooter;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" "
      "fill=\"#fff\"/>\n",
      width, height);
  double left = kMargin;
  for (const QuiverPanel& panel : panels) {
    svg += PanelPainter(panel, left, unit, full).paint();
    left += kPanel + kMargin;
  }
  return svg + "</svg>\n";
}

}  // namespace planar
