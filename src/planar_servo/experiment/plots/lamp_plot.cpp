#include "planar_servo/experiment/plots/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/report/plot.h"

namespace planar {
namespace {

constexpr int kCircleCorners = 120;
constexpr const char* kEdge = kSeriesColors[1];
constexpr char kFitted[] = "#d02020";

std::vector<Eigen::Vector2d> corners_of(const Circle& circle) {
  std::vector<Eigen::Vector2d> corners;
  for (int i = 0; i <= kCircleCorners; ++i) {
    const double angle = 2.0 * kPi * i / kCircleCorners;
    corners.emplace_back(circle.center +
                         circle.radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return corners;
}

double level_at(const LampEdges& lamp, const Eigen::Vector2d& uv_px) {
  const auto nearest = [](double px, int origin, int count) {
    return std::clamp(static_cast<int>(std::lround(px)) - origin, 0, count - 1);
  };
  return lamp.grey.at<std::uint8_t>(nearest(uv_px.y(), lamp.origin_px.y, lamp.grey.rows),
                                    nearest(uv_px.x(), lamp.origin_px.x, lamp.grey.cols));
}

/// Returns the rms distance of the edge points from the circle, pixels.
double departure_px(const LampEdges& lamp) {
  std::vector<double> distances;
  for (const Eigen::Vector2d& edge : lamp.edges_px)
    distances.push_back((edge - lamp.circle.center).norm() - lamp.circle.radius);
  return rms(distances);
}

Panel lamp_panel(const LampEdges& lamp, std::size_t number) {
  const double left = lamp.origin_px.x - 0.5, top = lamp.origin_px.y - 0.5;
  Panel panel(fmt::format("Lamp {}", number), {"u, px", left, left + lamp.grey.cols},
              {"v, px", top + lamp.grey.rows, top}, Panel::Aspect::kEqual);
  std::vector<double> levels;
  for (const Eigen::Vector2d& place : panel.field_places()) levels.push_back(level_at(lamp, place));
  const ColorScale scale("grey level", levels, ColorScale::Steps::kEven, ColorScale::Hues::kGrey);
  panel.add_field(levels, scale);
  panel.add_line(corners_of(lamp.circle), Panel::Stroke::kSolid, kFitted);
  panel.add_dots(lamp.edges_px, {kEdge}, 1.7);
  panel.add_dots({lamp.circle.center}, {kFitted}, 3.5);
  panel.add_key(kEdge, fmt::format("{} edge points", lamp.edges_px.size()));
  panel.add_key(kFitted,
                fmt::format("circle fitted to them, centre ({:.2f}, {:.2f}) px",
                            lamp.circle.center.x(), lamp.circle.center.y()),
                Panel::Sample::kLine);
  panel.add_note(fmt::format("the points depart from it by {:.3f} px rms", departure_px(lamp)));
  panel.add_color_bar(scale);
  return panel;
}

}  // namespace

std::optional<ReportPlot> lamp_plot(const std::vector<LampEdges>& lamps) {
  if (lamps.empty()) return std::nullopt;
  std::vector<Panel> panels;
  for (std::size_t i = 0; i < lamps.size(); ++i) panels.push_back(lamp_panel(lamps[i], i + 1));
  return paper_plot(
      6, "edge points of the two lamps, and the circles fitted to them",
      fmt::format("Image {} of the recording. The points are Canny's pixels, each moved to the "
                  "edge that grey moments find; the circle is fitted by least squares. Look where "
                  "the points leave the circle: an irregular rim pulls the centre, and pulls it "
                  "elsewhere when the tool is seen from another side.",
                  lamps.front().image),
      std::move(panels));
}

}  // namespace planar
