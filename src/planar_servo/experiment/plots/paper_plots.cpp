#include "planar_servo/experiment/plots/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/report/places.h"

namespace planar {
namespace {

using PlaceError = Eigen::Vector2d (CirclePlace::*)() const;

constexpr PlaceError kPlaceErrors[] = {&CirclePlace::seen_beside_plan,
                                       &CirclePlace::read_beside_plan, &CirclePlace::vision_error};

std::set<int> radii_of(const std::vector<CirclePlace>& places) {
  std::set<int> radii_mm;
  for (const CirclePlace& place : places) radii_mm.insert(place.radius_mm);
  return radii_mm;
}

std::vector<CirclePlace> places_of(const std::vector<CirclePlace>& places, int radius_mm, int run) {
  std::vector<CirclePlace> found;
  std::copy_if(
      places.begin(), places.end(), std::back_inserter(found),
      [&](const CirclePlace& place) { return place.radius_mm == radius_mm && place.run == run; });
  return found;
}

const char* color_of(const std::set<int>& radii_mm, int radius_mm) {
  const auto number = std::distance(radii_mm.begin(), radii_mm.find(radius_mm));
  return kSeriesColors[static_cast<std::size_t>(number) % std::size(kSeriesColors)];
}

/// Draws the lengths of an error along each circle, in the first run. Figures 8 to 10 have their
/// axes in common, so that they can be compared.
std::vector<Panel> length_panels(const std::string& title, const std::vector<CirclePlace>& places,
                                 PlaceError error) {
  double most = 0.0;
  int last = 0;
  for (const CirclePlace& place : places) {
    last = std::max(last, place.index);
    for (const PlaceError any : kPlaceErrors) most = std::max(most, mm((place.*any)().norm()));
  }
  const std::set<int> radii_mm = radii_of(places);
  Panel panel(title, {"number of the point along the circle", 0.0, last + 2.0},
              {"length of the error, mm", 0.0, 1.05 * most});
  for (const int radius_mm : radii_mm) {
    const std::vector<CirclePlace> circle = places_of(places, radius_mm, 1);
    if (circle.empty()) continue;
    const auto curve = each(circle, [&](const CirclePlace& place) {
      return Eigen::Vector2d(place.index + 1.0, mm((place.*error)().norm()));
    });
    const char* color = color_of(radii_mm, radius_mm);
    panel.add_line(curve, Panel::Stroke::kSolid, color);
    panel.add_dots(curve, {color}, 2.8);
    panel.add_key(color, fmt::format("radius {} mm: {:.3f} mm on average", radius_mm,
                                     mm(mean(lengths_of(each(circle, error))))));
  }
  return {panel};
}

/// Draws where the first run looked, with what vision sees beside the plan.
std::vector<Panel> places_panels(const std::vector<CirclePlace>& places) {
  std::vector<Eigen::Vector2d> planned, errors;
  for (const CirclePlace& place : places) {
    if (place.run != 1) continue;
    planned.push_back(place.p_plan / kMillimetre);
    errors.push_back(place.seen_beside_plan() / kMillimetre);
  }
  if (planned.empty()) return {};
  Panel panel("Places of the first run", axes_over_places(planned));
  panel.add_arrows(planned, errors, arrows_over(errors, "mm"));
  panel.add_dots({{0.0, 0.0}}, {"#111"}, 4.0);
  panel.add_note("lines: from the plan to what is seen, magnified");
  panel.add_note("large dot: the base's axis");
  return {panel};
}

/// The components of the vision error at one place in two runs, millimetres.
struct RunPair {
  std::vector<Eigen::Vector2d> both;     ///< first run across, later run up
  std::vector<Eigen::Vector2d> changes;  ///< number of the point across, change up, micrometres
};

RunPair compare_runs(const std::vector<CirclePlace>& first, const std::vector<CirclePlace>& later) {
  RunPair pair;
  for (const CirclePlace& before : first)
    for (const CirclePlace& after : later) {
      if (before.index != after.index) continue;
      const Eigen::Vector2d then = before.vision_error() / kMillimetre;
      const Eigen::Vector2d now = after.vision_error() / kMillimetre;
      pair.changes.emplace_back(before.index + 1.0,
                                (now - then).norm() * kMillimetre / kMicrometre);
      for (int axis = 0; axis < 2; ++axis) pair.both.emplace_back(then[axis], now[axis]);
    }
  return pair;
}

std::vector<Panel> correlation_panels(const std::vector<CirclePlace>& places) {
  const std::set<int> radii_mm = radii_of(places);
  std::vector<RunPair> pairs;
  std::vector<const char*> colors;
  std::vector<double> components, changes;
  std::vector<std::string> keys;
  double last = 0.0;
  for (const int radius_mm : radii_mm) {
    const std::vector<CirclePlace> first = places_of(places, radius_mm, 1);
    std::vector<double> correlations;
    for (int run = 2; run <= kRuns; ++run) {
      pairs.push_back(compare_runs(first, places_of(places, radius_mm, run)));
      colors.push_back(color_of(radii_mm, radius_mm));
      const RunPair& pair = pairs.back();
      if (pair.both.empty()) continue;
      const std::vector<double> both = components_of(pair.both);
      const auto later = both.begin() + static_cast<std::ptrdiff_t>(pair.both.size());
      correlations.push_back(correlation({both.begin(), later}, {later, both.end()}));
      components.insert(components.end(), both.begin(), both.end());
      for (const Eigen::Vector2d& change : pair.changes) {
        last = std::max(last, change.x());
        changes.push_back(change.y());
      }
    }
    keys.push_back(correlations.empty() ? fmt::format("radius {} mm", radius_mm)
                                        : fmt::format("radius {} mm: correlation {:.4f}", radius_mm,
                                                      mean(correlations)));
  }
  if (components.empty()) return {};
  const Axis across = axis_over("component in run 1, mm", components);
  Panel alike("Runs 2 and 3 over run 1", across,
              {"component in runs 2 and 3, mm", across.from, across.to}, Panel::Aspect::kEqual);
  Panel change("What changes from run to run",
               {"number of the point along the circle", 0.0, last + 1.0},
               {"change since run 1, \u00b5m", 0.0,
                1.05 * *std::max_element(changes.begin(), changes.end())});
  alike.add_line({{across.from, across.from}, {across.to, across.to}}, Panel::Stroke::kDashed);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    alike.add_dots(pairs[i].both, {colors[i]}, 2.6);
    change.add_dots(pairs[i].changes, {colors[i]}, 2.8);
  }
  for (std::size_t i = 0; i < keys.size(); ++i)
    alike.add_key(kSeriesColors[i % std::size(kSeriesColors)], keys[i]);
  return {alike, change};
}

constexpr const char* kEdge = kSeriesColors[1];
constexpr char kFitted[] = "#d02020";

double level_at(const LampEdges& lamp, const Eigen::Vector2d& uv_px) {
  const auto nearest = [](double px, int origin, int count) {
    return std::clamp(static_cast<int>(std::lround(px)) - origin, 0, count - 1);
  };
  return lamp.grey.at<std::uint8_t>(nearest(uv_px.y(), lamp.origin_px.y, lamp.grey.rows),
                                    nearest(uv_px.x(), lamp.origin_px.x, lamp.grey.cols));
}

/// Returns the rms distance of the edge points from the circle, pixels.
double departure_px(const LampEdges& lamp) {
  return rms(each(lamp.edges_px, [&](const Eigen::Vector2d& edge) {
    return (edge - lamp.circle.center).norm() - lamp.circle.radius;
  }));
}

Panel lamp_panel(const LampEdges& lamp, std::size_t number) {
  const double left = lamp.origin_px.x - 0.5, top = lamp.origin_px.y - 0.5;
  Panel panel(fmt::format("Lamp {}", number), {"u, px", left, left + lamp.grey.cols},
              {"v, px", top + lamp.grey.rows, top}, Panel::Aspect::kEqual);
  const std::vector<double> levels = each(
      panel.field_places(), [&](const Eigen::Vector2d& place) { return level_at(lamp, place); });
  const ColorScale scale("grey level", levels, ColorScale::Steps::kEven, ColorScale::Hues::kGrey);
  panel.add_field(levels, scale);
  panel.add_line(circle_of(lamp.circle.center, lamp.circle.radius), Panel::Stroke::kSolid, kFitted);
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
  return each(places_mm, [&](const Eigen::Vector2d& place) {
    const ErrorPrediction here = predict(map, place * kMillimetre);
    return here.inside ? mm(here.error.norm()) : std::numeric_limits<double>::quiet_NaN();
  });
}

/// Draws the error where it was measured to make the map, and the map with the error where it was
/// measured to judge it: on one scale of colours.
std::vector<Panel> field_panels(const PlotData& data, const DrawnMap& drawn) {
  const auto training_mm = in_mm(each(data.training, &PairRow::p_vision));
  const auto known_mm = lengths_of(in_mm(each(data.training, &PairRow::error)));
  const auto checks_mm = in_mm(each(data.checks, &PredictedPlace::p_vision));
  const auto measured_mm = lengths_of(in_mm(each(data.checks, &PredictedPlace::measured)));
  const FieldAxes axes = axes_over_places(training_mm);
  Panel known(fmt::format("(a) {} known places", known_mm.size()), axes);
  Panel field(std::string("(b) predicted by ") + drawn.name, axes);
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
  return mean(each(circle, [&](const PredictedPlace& place) {
    return mm((place.measured - place.*drawn.prediction).norm());
  }));
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
      const auto curve = each(circle, [&](const PredictedPlace& place) {
        return Eigen::Vector2d(place.index + 1.0, mm((place.*error).norm()));
      });
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

/// Returns the paper's Figures 7 to 11, on the circles that are gone round several times: where
/// they are, by how much vision and tracker find the arm beside the plan, by how much they differ,
/// and how alike that is between the runs. None without places.
std::vector<ReportPlot> circle_plots(const std::vector<CirclePlace>& places) {
  if (places_panels(places).empty() || correlation_panels(places).empty()) return {};
  const std::string data =
      " The data are the first of three runs, as the paper's chain has them before any map.";
  return {
      paper_plot(7, "places on the circles about the base",
                 "Every circle is gone round three times, with frames and a tracker reading at "
                 "each place. The lines show as vectors what Figure 8 measures. Check whether "
                 "they turn with the place: then no shift of the camera explains them." +
                     data,
                 places_panels(places)),
      paper_plot(8, "the arm's motion as vision finds it, against theory",
                 "The distance from where the cell file's arm should be to where vision sees it: "
                 "the arm's own error and vision's together. Check whether it grows with the "
                 "radius." +
                     data,
                 length_panels("Vision against theory", places, kPlaceErrors[0])),
      paper_plot(9, "the arm's motion as the tracker finds it, against theory",
                 "The same with the tracker in place of vision: the arm's own error, and the "
                 "little that the tracker adds. What differs from Figure 8, which has the same "
                 "axes, is vision's." +
                     data,
                 length_panels("Tracker against theory", places, kPlaceErrors[1])),
      paper_plot(10, "the vision error: vision against tracker",
                 "What a map of the vision error has to predict, on the axes of Figures 8 and 9. "
                 "Look at the means: in the paper they grow with the radius." +
                     data,
                 length_panels("Vision against tracker", places, kPlaceErrors[2])),
      paper_plot(11, "correlation of the vision error between runs",
                 "First, the components of the vision error in runs 2 and 3 over those of run 1, "
                 "by the paper's chain: on the dashed line they are the same. Table 1 has the "
                 "mean over all three pairs of runs. Then by how much the error has changed, "
                 "in micrometres: that is noise, which no map can take off.",
                 correlation_panels(places))};
}

/// Returns the paper's Figure 6: edge points and fitted circles of both lamps; none without lamps.
std::vector<ReportPlot> lamp_plot(const std::vector<LampEdges>& lamps) {
  if (lamps.empty()) return {};
  std::vector<Panel> panels;
  for (std::size_t i = 0; i < lamps.size(); ++i) panels.push_back(lamp_panel(lamps[i], i + 1));
  return {paper_plot(
      6, "edge points of the two lamps, and the circles fitted to them",
      fmt::format("Image {} of the recording. The points are Canny's pixels, each moved to the "
                  "edge that grey moments find; the circle is fitted by least squares. Look where "
                  "the points leave the circle: an irregular rim pulls the centre, and pulls it "
                  "elsewhere when the tool is seen from another side.",
                  lamps.front().image),
      std::move(panels))};
}

/// Returns the paper's Figures 13 to 16: the vision error at the training places, over the field as
/// inverse distance weighting and as radial basis functions predict it, and measured against
/// predicted along the check circles.
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

}  // namespace

std::vector<ReportPlot> paper_plots(const PlotData& data) {
  std::vector<ReportPlot> plots = lamp_plot(data.lamps);
  for (const auto& more : {circle_plots(data.circles), map_plots(data)})
    plots.insert(plots.end(), more.begin(), more.end());
  return plots;
}

}  // namespace planar
