#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/experiment/plots/plots.h"
#include "planar_servo/report/places.h"

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

constexpr char kMeasuredColor[] = "#1f4e79", kPredictedColor[] = "#c77f1a";

/// One of the two maps of the figures.
struct DrawnMap {
  const char* name;
  const ErrorMap& map;
  Eigen::Vector2d PredictedPlace::*prediction;
};

/// Returns the lengths that a map predicts at places in millimetres; NaN where it is not valid.
std::vector<double> field_of(const ErrorMap& map, const std::vector<Eigen::Vector2d>& places_mm) {
  std::vector<double> lengths_mm;
  for (const Eigen::Vector2d& place : places_mm) {
    const ErrorPrediction here = predict(map, place * kMillimetre);
    lengths_mm.push_back(here.inside ? mm(here.error.norm())
                                     : std::numeric_limits<double>::quiet_NaN());
  }
  return lengths_mm;
}

/// Draws the error where it was measured to make the map, and the map with the error where it was
/// measured to judge it: on one scale of colours.
std::vector<Panel> field_panels(const PlotData& data, const DrawnMap& drawn) {
  std::vector<Eigen::Vector2d> training_mm, checks_mm;
  std::vector<double> known_mm, measured_mm;
  for (const TrainingPlace& place : data.training) {
    training_mm.push_back(place.p_vision / kMillimetre);
    known_mm.push_back(mm(place.error.norm()));
  }
  for (const PredictedPlace& place : data.checks) {
    checks_mm.push_back(place.p_vision / kMillimetre);
    measured_mm.push_back(mm(place.measured.norm()));
  }
  const FieldAxes axes = axes_over_places(training_mm);
  Panel known(fmt::format("(a) {} known places", known_mm.size()), axes.x, axes.y,
              Panel::Aspect::kEqual);
  Panel field(std::string("(b) predicted by ") + drawn.name, axes.x, axes.y, Panel::Aspect::kEqual);
  const std::vector<double> predicted_mm = field_of(drawn.map, field.field_places());
  std::vector<double> all_mm = predicted_mm;
  all_mm.insert(all_mm.end(), known_mm.begin(), known_mm.end());
  all_mm.insert(all_mm.end(), measured_mm.begin(), measured_mm.end());
  const ColorScale scale("length of the vision error, mm", all_mm);
  known.add_dots(training_mm, {"", &scale, known_mm}, 5.0);
  field.add_field(predicted_mm, scale);
  field.add_dots(checks_mm, {"", &scale, measured_mm}, 5.0);
  field.add_color_bar(scale);
  return {known, field};
}

/// Returns the mean length of what a prediction leaves of the error, millimetres.
double left_mm(const std::vector<PredictedPlace>& circle, const DrawnMap& drawn) {
  std::vector<double> left;
  left.reserve(circle.size());
  for (const PredictedPlace& place : circle)
    left.push_back(mm((place.measured - place.*drawn.prediction).norm()));
  return mean(left);
}

/// Draws measured and predicted lengths along each check circle, on common axes.
std::vector<Panel> prediction_panels(const PlotData& data, const DrawnMap& drawn) {
  std::set<int> radii_mm;
  double most = 0.0;
  int last = 0;
  for (const PredictedPlace& place : data.checks) {
    radii_mm.insert(place.radius_mm);
    last = std::max(last, place.index);
    for (const Eigen::Vector2d& error : {place.measured, place.by_idw, place.by_rbf})
      most = std::max(most, mm(error.norm()));
  }
  std::vector<Panel> panels;
  for (const int radius_mm : radii_mm) {
    std::vector<PredictedPlace> circle;
    for (const PredictedPlace& place : data.checks)
      if (place.radius_mm == radius_mm) circle.push_back(place);
    Panel panel(fmt::format("Radius {} mm", radius_mm),
                {"number of the point along the circle", 0.0, last + 2.0},
                {"length of the vision error, mm", 0.0, 1.05 * most});
    const auto add = [&](Eigen::Vector2d PredictedPlace::*error, const char* color) {
      std::vector<Eigen::Vector2d> curve;
      curve.reserve(circle.size());
      for (const PredictedPlace& place : circle)
        curve.emplace_back(place.index + 1.0, mm((place.*error).norm()));
      panel.add_line(curve, Panel::Stroke::kSolid, color);
      panel.add_dots(curve, {color}, 2.8);
    };
    add(&PredictedPlace::measured, kMeasuredColor);
    add(drawn.prediction, kPredictedColor);
    panel.add_key(kMeasuredColor, "measured");
    panel.add_key(kPredictedColor, std::string("predicted by ") + drawn.name);
    panel.add_note(fmt::format("remaining error: {:.3f} mm on average", left_mm(circle, drawn)));
    panels.push_back(std::move(panel));
  }
  return panels;
}

std::string field_caption(const std::string& map, const std::string& look) {
  return "The length of the vision error in the base frame, by the paper's chain. (a) The training "
         "places, which are drawn over the workspace. (b) What " +
         map +
         " predicts from them, with the places of the check circles, which it has not seen, in "
         "the colour of what was measured there. " +
         look;
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

std::vector<ReportPlot> map_plots(const PlotData& data) {
  if (data.training.empty() || data.checks.empty()) return {};
  const DrawnMap idw{"IDW", data.idw, &PredictedPlace::by_idw};
  const DrawnMap rbf{"RBF", data.rbf, &PredictedPlace::by_rbf};
  return {
      paper_plot(13, "known errors, and errors predicted by inverse distance weighting",
                 field_caption("inverse distance weighting",
                               "Look for spots about the known places, and for dots that stand "
                               "out from the field."),
                 field_panels(data, idw)),
      paper_plot(14, "measured errors and those predicted by inverse distance weighting",
                 "Along the check circles, by the paper's chain. Check whether the prediction is "
                 "flatter than what was measured: weighted means cannot leave the range of their "
                 "neighbours. The number below each panel counts wrong directions as well; Table "
                 "2 has the accuracies.",
                 prediction_panels(data, idw)),
      paper_plot(15, "known errors, and errors predicted by radial basis functions",
                 field_caption("the paper's Gaussian network",
                               "Dots that melt into the field are predicted well. Look at the "
                               "rim, where the map has neighbours on one side only."),
                 field_panels(data, rbf)),
      paper_plot(16, "measured errors and those predicted by radial basis functions",
                 "The places and axes of Figure 14, by the paper's Gaussian network. Look at "
                 "what is left of the vectors, beside Figure 14; Table 5 has the accuracies.",
                 prediction_panels(data, rbf))};
}

}  // namespace planar
