#include "planar_servo/report/panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "planar_servo/report/html_page.h"
#include "planar_servo/report/places.h"

namespace planar {
namespace {

constexpr double kLeft = 62.0, kTop = 34.0, kRight = 16.0,
                 kBottom = 44.0;      // about a plot
constexpr double kLine = 20.0;        // of the legend
constexpr double kLongestBar = 60.0;  // of the arrows' legend
constexpr double kTickSpacing = 48.0;
constexpr double kOverlap = 0.4;  // of a field's cells, so that no seam shows

std::string text(const char* of_class, double x, double y, const char* anchor,
                 const std::string& content) {
  return fmt::format("<text class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n",
                     of_class, x, y, anchor, html_escaped(content));
}

int most_ticks(double length) {
  return std::max(3, static_cast<int>(length / kTickSpacing) + 1);
}

std::string path_through(const std::vector<Eigen::Vector2d>& points) {
  std::string path;
  for (const Eigen::Vector2d& p : points)
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : " L", p.x(), p.y());
  return path;
}

std::string line_svg(const char* of_class, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                     const std::string& color) {
  return fmt::format(
      "<line class=\"{}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"/>",
      of_class, from.x(), from.y(), to.x(), to.y(), color);
}

/// The style of the marks and lines of a series. An empty shape is a round dot; others are paths
/// about it, of a dot's area at radius 1.
struct SeriesStyle {
  std::vector<Eigen::Vector2d> corners;
  const char* dashes;
};

const SeriesStyle& style_of(const std::string& color) {
  static const SeriesStyle styles[] = {
      {{}, ""},
      {{{-0.9, -0.9}, {0.9, -0.9}, {0.9, 0.9}, {-0.9, 0.9}}, "7 3"},
      {{{0.0, -1.5}, {1.3, 0.8}, {-1.3, 0.8}}, "2 2.5"},
      {{{0.0, -1.4}, {1.25, 0.0}, {0.0, 1.4}, {-1.25, 0.0}}, "9 3 2 3"},
      {{{0.0, 1.5}, {1.3, -0.8}, {-1.3, -0.8}}, "12 5"}};
  static_assert(std::size(styles) == std::size(kSeriesColors));
  const auto found = std::find(std::begin(kSeriesColors), std::end(kSeriesColors), color);
  return styles[found == std::end(kSeriesColors) ? 0 : found - std::begin(kSeriesColors)];
}

std::string mark_svg(const Eigen::Vector2d& p, double radius, const std::string& color) {
  const std::vector<Eigen::Vector2d>& corners = style_of(color).corners;
  if (corners.empty())
    return fmt::format(
        "<circle class=\"dot\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:g}\" fill=\"{}\"/>\n", p.x(),
        p.y(), radius, color);
  const auto placed = each(
      corners, [&](const Eigen::Vector2d& corner) { return Eigen::Vector2d(p + radius * corner); });
  return fmt::format("<path class=\"dot\" d=\"{}Z\" fill=\"{}\"/>\n", path_through(placed), color);
}

std::string dashes_of(const std::string& color) {
  const std::string dashes = style_of(color).dashes;
  return dashes.empty() ? "" : " stroke-dasharray=\"" + dashes + "\"";
}

}  // namespace

ArrowScale arrows_over(const std::vector<Eigen::Vector2d>& vectors, const std::string& unit) {
  double longest = 0.0;
  for (const Eigen::Vector2d& vector : vectors) longest = std::max(longest, vector.norm());
  return {longest, unit};
}

Panel::Panel(std::string title, Axis x, Axis y, Aspect aspect)
    : title_(std::move(title)),
      x_(std::move(x)),
      y_(std::move(y)),
      plot_width_(kPanelWidth),
      plot_height_(kPanelHeight) {
  if (aspect == Aspect::kFree) return;
  const double wide = x_.highest() - x_.lowest(), high = y_.highest() - y_.lowest();
  const double unit = std::min(kPanelWidth / wide, kPanelHeight / high);
  plot_width_ = unit * wide;
  plot_height_ = unit * high;
}

Eigen::Vector2d Panel::at(const Eigen::Vector2d& p) const {
  return {kLeft + plot_width_ * x_.share(p.x()), kTop + plot_height_ * (1.0 - y_.share(p.y()))};
}

std::size_t Panel::stride(std::size_t marks) {
  const std::size_t stride = (marks + kMostMarks - 1) / kMostMarks;
  if (stride > 1) add_note(fmt::format("drawn is one of {}, of {} in all", stride, marks));
  return std::max<std::size_t>(stride, 1);
}

std::vector<Eigen::Vector2d> Panel::field_places() const {
  const auto along = [](const Axis& axis, int i) {
    return axis.from + (i + 0.5) / kFieldCells * (axis.to - axis.from);
  };
  std::vector<Eigen::Vector2d> places;
  for (int row = 0; row < kFieldCells; ++row)
    for (int column = 0; column < kFieldCells; ++column)
      places.emplace_back(along(x_, column), along(y_, kFieldCells - 1 - row));
  return places;
}

void Panel::add_field(const std::vector<double>& values, const ColorScale& scale) {
  if (values.size() != static_cast<std::size_t>(kFieldCells) * kFieldCells)
    throw std::invalid_argument("a field needs a value for each of its places");
  const double wide = plot_width_ / kFieldCells, high = plot_height_ / kFieldCells;
  std::vector<std::string> colors(values.size());
  std::transform(values.begin(), values.end(), colors.begin(),
                 [&](double value) { return std::isfinite(value) ? scale.color(value) : ""; });
  marks_ += "<g shape-rendering=\"crispEdges\">\n";
  auto cell = colors.begin();
  for (int row = 0; row < kFieldCells; ++row)
    for (int column = 0, end = 0; column < kFieldCells; column = end) {
      // Cells of one colour in a row become one rectangle.
      const std::string& color = *cell;
      for (; end < kFieldCells && *cell == color; ++end) ++cell;
      if (color.empty()) continue;
      const double left = kLeft + column * wide, right = kLeft + end * wide;
      marks_ += fmt::format(
          "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n",
          left, kTop + row * high, right - left + kOverlap, high + kOverlap, color);
    }
  marks_ += "</g>\n";
}

void Panel::add_arrows(const std::vector<Eigen::Vector2d>& points,
                       const std::vector<Eigen::Vector2d>& vectors, const ArrowScale& scale,
                       const Paint& paint) {
  if (points.size() != vectors.size())
    throw std::invalid_argument("arrows need as many vectors as points");
  const Eigen::Vector2d along(x_.from < x_.to ? 1.0 : -1.0, y_.from < y_.to ? -1.0 : 1.0);
  const double unit = scale.longest > 0.0 ? kLongestArrow / scale.longest : 0.0;
  const std::size_t step = stride(points.size());
  std::string halos, arrows;
  for (std::size_t i = 0; i < points.size(); i += step) {
    const Eigen::Vector2d from = at(points[i]);
    const Eigen::Vector2d to = from + unit * along.cwiseProduct(vectors[i]);
    halos += line_svg("halo", from, to, "#fff") + '\n';
    arrows += line_svg("arrow", from, to, paint.of(i)) + mark_svg(from, 1.7, paint.of(i));
  }
  marks_ += halos + arrows;
  if (unit == 0.0) return;
  const double bar = round_length(kLongestBar / unit);
  legend_.push_back(
      line_svg("arrow", {0.0, -4.0}, {unit * bar, -4.0}, "#222") +
      text("tick", unit * bar + 6.0, 0.0, "start", fmt::format("{:g} {}", bar, scale.unit)));
}

void Panel::add_dots(const std::vector<Eigen::Vector2d>& points, const Paint& paint,
                     double radius) {
  const std::size_t step = stride(points.size());
  for (std::size_t i = 0; i < points.size(); i += step)
    marks_ += mark_svg(at(points[i]), radius, paint.of(i));
}

void Panel::add_line(const std::vector<Eigen::Vector2d>& points, Stroke stroke,
                     const std::string& color) {
  const auto placed = each(points, [this](const Eigen::Vector2d& p) { return at(p); });
  marks_ += fmt::format("<path class=\"line{}\" stroke=\"{}\" d=\"{}\"{}/>\n",
                        stroke == Stroke::kDashed ? " dashed" : "", color, path_through(placed),
                        dashes_of(color));
}

void Panel::add_bars(const std::vector<double>& edges, const std::vector<double>& heights) {
  if (edges.size() != heights.size() + 1)
    throw std::invalid_argument("bars need one more edge than heights");
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const Eigen::Vector2d top = at({edges[i], heights[i]}), base = at({edges[i + 1], 0.0});
    marks_ += fmt::format(
        "<rect class=\"bar\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>\n",
        top.x(), top.y(), base.x() - top.x(), base.y() - top.y());
  }
}

void Panel::add_color_bar(const ColorScale& scale) {
  bar_ = scale.bar_svg(kLeft + plot_width_ + kRight, kTop, plot_height_);
}

void Panel::add_note(const std::string& note) {
  legend_.push_back(text("tick", 0.0, 0.0, "start", note));
  words_.push_back(note);
}

void Panel::add_keys(const std::vector<Key>& keys) {
  std::string line, words;
  double x = 0.0;
  for (const auto& [color, what, sample] : keys) {
    const bool is_line = sample == Sample::kLine;
    line += fmt::format(
        "<g transform=\"translate({:.1f} 0)\"><g class=\"key\">{}</g>{}</g>", x,
        is_line ? fmt::format("<path class=\"line\" stroke=\"{}\" d=\"M0 -4 L26 -4\"{}/>", color,
                              dashes_of(color))
                : mark_svg({5.0, -4.0}, 4.0, color),
        text("tick", is_line ? 32.0 : 15.0, 0.0, "start", what));
    words += (words.empty() ? "" : ", ") + what;
    x += plot_width_ / static_cast<double>(keys.size());
  }
  legend_.push_back(line);
  words_.push_back(words);
}

std::string Panel::description() const {
  std::string words = y_.label + " over " + x_.label + '.';
  for (const std::string& line : words_) words += ' ' + line + '.';
  return words;
}

Ticks Panel::ticks_along_x() const {
  constexpr int kFewest = 3;
  constexpr double kDigit = 7.0, kGap = 8.0;  // of numbers below the plot
  for (int most = most_ticks(plot_width_);; --most) {
    Ticks ticks = x_.ticks(most);
    double room = plot_width_, widest = 0.0;
    for (std::size_t i = 0; i < ticks.values.size(); ++i) {
      widest = std::max(widest, kDigit * static_cast<double>(ticks.text(ticks.values[i]).size()));
      if (i > 0)
        room = std::min(room,
                        plot_width_ * (x_.share(ticks.values[i]) - x_.share(ticks.values[i - 1])));
    }
    if (most <= kFewest || std::abs(room) >= widest + kGap) return ticks;
  }
}

std::string Panel::axes() const {
  std::string lines, numbers;
  const Ticks along_x = ticks_along_x();
  for (const double value : along_x.values) {
    const double x = at({value, y_.from}).x();
    lines += line_svg("grid", {x, kTop}, {x, kTop + plot_height_}, "#e4e4e0") + '\n';
    numbers += text("tick", x, kTop + plot_height_ + 15.0, "middle", along_x.text(value));
  }
  const Ticks along_y = y_.ticks(most_ticks(plot_height_));
  for (const double value : along_y.values) {
    const double y = at({x_.from, value}).y();
    lines += line_svg("grid", {kLeft, y}, {kLeft + plot_width_, y}, "#e4e4e0") + '\n';
    numbers += text("tick", kLeft - 6.0, y + 4.0, "end", along_y.text(value));
  }
  const double middle = kTop + 0.5 * plot_height_;
  return lines + numbers +
         text("label", kLeft + 0.5 * plot_width_, kTop + plot_height_ + 33.0, "middle", x_.label) +
         fmt::format("<g transform=\"rotate(-90 14 {0:.1f})\">{1}</g>\n", middle,
                     text("label", 14.0, middle, "middle", y_.label));
}

std::string Panel::svg(double left) const {
  std::string svg = fmt::format("<g transform=\"translate({:.1f} 0)\">\n", left);
  svg += text("title", kLeft, 20.0, "start", title_) + axes() + marks_;
  svg +=
      fmt::format("<rect class=\"frame\" x=\"{}\" y=\"{}\" width=\"{:.1f}\" height=\"{:.1f}\"/>\n",
                  kLeft, kTop, plot_width_, plot_height_);
  double y = kTop + plot_height_ + kBottom + 14.0;
  for (const std::string& line : legend_) {
    svg += fmt::format("<g transform=\"translate({} {:.1f})\">{}</g>\n", kLeft, y, line);
    y += kLine;
  }
  return svg + bar_ + "</g>\n";
}

double Panel::width() const {
  return kLeft + plot_width_ + kRight + (bar_.empty() ? 0.0 : kColorBarWidth);
}

double Panel::height() const {
  return kTop + plot_height_ + kBottom + kLine * static_cast<double>(legend_.size());
}

}  // namespace planar
