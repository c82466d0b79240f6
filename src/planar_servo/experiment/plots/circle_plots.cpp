#include "planar_servo/experiment/plots/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <set>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/report/places.h"

namespace planar {
namespace {

/// Computes an error of a place, metres.
using PlaceError = std::function<Eigen::Vector2d(const CirclePlace&)>;

Eigen::Vector2d seen_beside_plan(const CirclePlace& place) {
  return place.p_vision - place.p_plan;
}

Eigen::Vector2d read_beside_plan(const CirclePlace& place) {
  return place.p_tracker - place.p_plan;
}

Eigen::Vector2d seen_beside_read(const CirclePlace& place) {
  return place.vision_error();
}

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
                                 const PlaceError& error) {
  double most = 0.0;
  int last = 0;
  for (const CirclePlace& place : places) {
    last = std::max(last, place.index);
    for (const auto& each : {seen_beside_plan, read_beside_plan, seen_beside_read})
      most = std::max(most, mm(each(place).norm()));
  }
  const std::set<int> radii_mm = radii_of(places);
  Panel panel(title, {"number of the point along the circle", 0.0, last + 2.0},
              {"length of the error, mm", 0.0, 1.05 * most});
  for (const int radius_mm : radii_mm) {
    const std::vector<CirclePlace> circle = places_of(places, radius_mm, 1);
    if (circle.empty()) continue;
    std::vector<double> lengths;
    std::vector<Eigen::Vector2d> curve;
    for (const CirclePlace& place : circle) {
      lengths.push_back(mm(error(place).norm()));
      curve.emplace_back(place.index + 1.0, lengths.back());
    }
    const char* color = color_of(radii_mm, radius_mm);
    panel.add_line(curve, Panel::Stroke::kSolid, color);
    panel.add_dots(curve, {color}, 2.8);
    panel.add_key(color,
                  fmt::format("radius {} mm: {:.3f} mm on average", radius_mm, mean(lengths)));
  }
  return {panel};
}

/// Draws where the first run looked, with what vision sees beside the plan.
std::vector<Panel> places_panels(const std::vector<CirclePlace>& places) {
  std::vector<Eigen::Vector2d> planned, errors;
  for (const CirclePlace& place : places) {
    if (place.run != 1) continue;
    planned.push_back(place.p_plan / kMillimetre);
    errors.push_back(seen_beside_plan(place) / kMillimetre);
  }
  if (planned.empty()) return {};
  const FieldAxes axes = axes_over_places(planned);
  Panel panel("Places of the first run", axes.x, axes.y, Panel::Aspect::kEqual);
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
  std::vector<double> first, later;
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
      for (int axis = 0; axis < 2; ++axis) {
        pair.both.emplace_back(then[axis], now[axis]);
        pair.first.push_back(then[axis]);
        pair.later.push_back(now[axis]);
      }
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
      if (pair.first.empty()) continue;
      correlations.push_back(correlation(pair.first, pair.later));
      components.insert(components.end(), pair.first.begin(), pair.first.end());
      components.insert(components.end(), pair.later.begin(), pair.later.end());
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

}  // namespace

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
                 length_panels("Vision against theory", places, seen_beside_plan)),
      paper_plot(9, "the arm's motion as the tracker finds it, against theory",
                 "The same with the tracker in place of vision: the arm's own error, and the "
                 "little that the tracker adds. What differs from Figure 8, which has the same "
                 "axes, is vision's." +
                     data,
                 length_panels("Tracker against theory", places, read_beside_plan)),
      paper_plot(10, "the vision error: vision against tracker",
                 "What a map of the vision error has to predict, on the axes of Figures 8 and 9. "
                 "Look at the means: in the paper they grow with the radius." +
                     data,
                 length_panels("Vision against tracker", places, seen_beside_read)),
      paper_plot(11, "correlation of the vision error between runs",
                 "First, the components of the vision error in runs 2 and 3 over those of run 1, "
                 "by the paper's chain: on the dashed line they are the same. Table 1 has the "
                 "mean over all three pairs of runs. Then by how much the error has changed, "
                 "in micrometres: that is noise, which no map can take off.",
                 correlation_panels(places))};
}

}  // namespace planar
