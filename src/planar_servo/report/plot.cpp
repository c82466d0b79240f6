#include "planar_servo/report/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/places.h"

namespace planar {
namespace {

constexpr char kPlotStyle[] =
    "svg text{font-family:system-ui,sans-serif;fill:#222}"
    "svg .title{font-size:14px;font-weight:600}svg .label{font-size:13px}"
    "svg .tick{font-size:12px;fill:#444}"
    "svg .frame{fill:none;stroke:#777}svg .halo{stroke-width:3.6;stroke-linecap:round}"
    "svg .arrow{stroke-width:1.5;stroke-linecap:round}svg .dot{stroke:#fff;stroke-width:.5}"
    "svg .line{fill:none;stroke-width:1.3}svg .dashed{stroke-dasharray:5 4}"
    "svg .bar{fill:#5b8db8;stroke:#fff;stroke-width:.6}";

constexpr double kBetweenPanels = 10.0;
constexpr double kLeastShown = 0.75;  // of a panel's size, before it goes below the others
constexpr double kBeyond = 6.0;       // robust deviations
constexpr double kBarsPerSigma = 2.5;
constexpr int kCurvePoints = 80;

/// The edges of bars of a round width that hold the values within `reach` of their median.
std::vector<double> bar_edges(const std::vector<double>& values, double middle, double reach) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const double from = std::max(*least, middle - reach), to = std::min(*most, middle + reach);
  const double width = reach > 0.0 ? round_length(reach / (kBeyond * kBarsPerSigma)) : 1.0;
  std::vector<double> edges;
  for (double i = std::floor(from / width); i <= std::ceil(to / width); ++i)
    edges.push_back(i * width);
  if (edges.size() < 2) edges.push_back(edges.front() + width);
  return edges;
}

/// Returns how many values lie from each edge to the next.
std::vector<double> counts_between(const std::vector<double>& edges,
                                   const std::vector<double>& values) {
  std::vector<double> counts(edges.size() - 1, 0.0);
  for (const double value : values) {
    if (value < edges.front() || value > edges.back()) continue;
    const auto above = std::upper_bound(edges.begin() + 1, edges.end() - 1, value);
    ++counts[static_cast<std::size_t>(above - edges.begin() - 1)];
  }
  return counts;
}

std::vector<Eigen::Vector2d> normal_curve(const Axis& x, double sigma, double area) {
  std::vector<Eigen::Vector2d> curve;
  for (int i = 0; sigma > 0.0 && i <= kCurvePoints; ++i) {
    const double at = x.from + (x.to - x.from) * i / kCurvePoints;
    curve.emplace_back(
        at, area / (sigma * std::sqrt(2.0 * kPi)) * std::exp(-0.5 * at * at / (sigma * sigma)));
  }
  return curve;
}

}  // namespace

std::string plot_svg(const std::vector<Panel>& panels) {
  double width = 0.0, height = 0.0;
  std::string titles, words, drawn;
  for (const Panel& panel : panels) {
    titles += (titles.empty() ? "" : "; ") + panel.title();
    words += (words.empty() ? "" : " ") + panel.description();
    drawn += panel.svg(width);
    width += panel.width() + kBetweenPanels;
    height = std::max(height, panel.height());
  }
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" viewBox=\"0 0 {0:.0f} "
             "{1:.0f}\" "
             "width=\"{0:.0f}\" height=\"{1:.0f}\">\n<title>{2}</title>\n<desc>{3}</desc>\n"
             "<style>{4}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
             width, height, html_escaped(titles), html_escaped(words), kPlotStyle) +
         drawn + "</svg>\n";
}

std::string plot_html(const std::vector<Panel>& panels) {
  std::string html = "<div class=\"panels\">\n";
  for (const Panel& panel : panels)
    html +=
        fmt::format("<div style=\"flex:{0:.0f} 1 {1:.0f}px;max-width:{0:.0f}px\">\n{2}</div>\n",
                    panel.width() + kBetweenPanels, kLeastShown * panel.width(), plot_svg({panel}));
  return html + "</div>\n";
}

Panel component_panel(const std::string& title, const Axis& over, const Axis& components,
                      const std::vector<double>& at, const std::vector<Eigen::Vector2d>& vectors) {
  std::vector<Eigen::Vector2d> x, y;
  for (std::size_t i = 0; i < at.size(); ++i) {
    x.emplace_back(at[i], vectors[i].x());
    y.emplace_back(at[i], vectors[i].y());
  }
  Panel panel(title, over, components);
  panel.add_line({{over.from, 0.0}, {over.to, 0.0}});
  panel.add_dots(x, {kSeriesColors[0]});
  panel.add_dots(y, {kSeriesColors[1]});
  panel.add_key(kSeriesColors[0], "along x");
  panel.add_key(kSeriesColors[1], "along y");
  return panel;
}

Panel histogram(const std::string& title, const std::string& label,
                const std::vector<double>& values, const NormalCurve& expected) {
  const double spread = std::max(robust_sigma(values), expected.sigma);
  const std::vector<double> edges = bar_edges(values, median(values), kBeyond * spread);
  const std::vector<double> counts = counts_between(edges, values);
  const Axis x{label, edges.front(), edges.back()};
  const std::vector<Eigen::Vector2d> curve =
      normal_curve(x, expected.sigma, static_cast<double>(values.size()) * (edges[1] - edges[0]));
  double top = *std::max_element(counts.begin(), counts.end()), counted = 0.0;
  for (const Eigen::Vector2d& p : curve) top = std::max(top, p.y());
  for (const double count : counts) counted += count;
  Panel panel(title, x, {"how many", 0.0, 1.08 * top});
  panel.add_bars(edges, counts);
  panel.add_line(curve);
  panel.add_note(fmt::format("curve: normal with {}, {:.3g}", expected.what, expected.sigma));
  if (const double beyond = static_cast<double>(values.size()) - counted; beyond > 0.0)
    panel.add_note(fmt::format("{:.0f} beyond the ends", beyond));
  return panel;
}

std::vector<Panel> quiver_panels(const std::vector<QuiverPanel>& panels) {
  std::vector<Eigen::Vector2d> all_points, all_errors;
  for (const QuiverPanel& panel : panels) {
    if (panel.points.empty() || panel.points.size() != panel.errors.size())
      throw std::invalid_argument("a quiver panel needs as many errors as points, at least one");
    all_points.insert(all_points.end(), panel.points.begin(), panel.points.end());
    all_errors.insert(all_errors.end(), panel.errors.begin(), panel.errors.end());
  }
  const FieldAxes axes = axes_over_places(in_mm(all_points));
  const ArrowScale arrows = arrows_over(in_mm(all_errors), "mm");
  const ColorScale colors("error, mm", lengths_of(in_mm(all_errors)), ColorScale::Steps::kDecades);
  std::vector<Panel> drawn;
  for (const QuiverPanel& panel : panels) {
    const std::vector<Eigen::Vector2d> errors = in_mm(panel.errors);
    drawn.emplace_back(panel.title, axes);
    drawn.back().add_arrows(in_mm(panel.points), errors, arrows, {"", &colors, lengths_of(errors)});
  }
  drawn.back().add_color_bar(colors);
  return drawn;
}

}  // namespace planar
