#include "planar_servo/experiment/plots/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"
#include "planar_servo/work/run/servo_report.h"

namespace planar {
namespace {

/// Errors at the targets under one way of positioning.
struct ErrorSeries {
  const char* what;
  const char* color;
  const std::vector<TargetResult>& results;
  TargetError error;

  std::vector<double> lengths_mm() const { return each(error_lengths(results, error), mm); }
};

std::vector<ErrorSeries> series_of(const ExperimentReport& report) {
  return {{"before feedback", kSeriesColors[4], report.paper, &TargetResult::before_judged},
          {"paper's, no map", kSeriesColors[3], report.paper_no_map, &TargetResult::after_judged},
          {"paper's chain", kSeriesColors[1], report.paper, &TargetResult::after_judged},
          {"ours", kSeriesColors[0], report.ours, &TargetResult::after_judged}};
}

Axis error_axis(const ExperimentReport& report) {
  std::vector<double> all;
  for (const ErrorSeries& series : series_of(report))
    for (const double length : series.lengths_mm()) all.push_back(length);
  return decades_over("error, mm", all);
}

std::vector<Panel> target_panels(const ExperimentReport& report) {
  std::vector<Eigen::Vector2d> all;
  for (const ControlCircle& circle : report.circles)
    for (const TargetRow& target : circle.targets) all.push_back(target.p_d);
  Panel panel("Targets", axes_over_places(in_mm(all)));
  for (std::size_t i = 0; i < report.circles.size(); ++i) {
    const ControlCircle& circle = report.circles[i];
    const char* color = kSeriesColors[i % std::size(kSeriesColors)];
    panel.add_dots(in_mm(each(circle.targets, &TargetRow::p_d)), {color}, 3.4);
    panel.add_key(color, fmt::format("{} targets about ({:.0f}, {:.0f}) mm", circle.targets.size(),
                                     mm(circle.center.x()), mm(circle.center.y())));
  }
  panel.add_dots({{0.0, 0.0}}, {"#111"}, 4.0);
  panel.add_note("large dot: the base's axis");
  return {panel};
}

/// Draws each target's error, in the order in which the arm goes to them.
std::vector<Panel> before_after_panels(const ExperimentReport& report) {
  Panel panel("Error at each target",
              {"number of the target", 0.0, static_cast<double>(report.paper.size()) + 1.0},
              error_axis(report));
  for (const ErrorSeries& series : series_of(report)) {
    if (series.lengths_mm().empty()) continue;
    std::vector<Eigen::Vector2d> points;
    for (std::size_t i = 0; i < series.results.size(); ++i)
      if (const auto& error = series.results[i].*series.error)
        points.emplace_back(static_cast<double>(i) + 1.0, mm(error->norm()));
    panel.add_dots(points, {series.color}, 3.0);
    panel.add_key(series.color,
                  fmt::format("{}: {:#.3g} mm on average", series.what, mean(series.lengths_mm())));
  }
  return {panel};
}

/// Draws for each length the share of the targets that end nearer.
Panel cumulative_panel(const ExperimentReport& report) {
  Panel panel("Targets that end nearer than ...", error_axis(report), {"share, %", 0.0, 104.0});
  for (const ErrorSeries& series : series_of(report)) {
    std::vector<double> lengths = series.lengths_mm();
    if (lengths.empty()) continue;
    std::sort(lengths.begin(), lengths.end());
    std::vector<Eigen::Vector2d> curve{{lengths.front(), 0.0}};
    for (std::size_t i = 0; i < lengths.size(); ++i)
      for (const std::size_t count : {i, i + 1})
        curve.emplace_back(
            lengths[i], 100.0 * static_cast<double>(count) / static_cast<double>(lengths.size()));
    panel.add_line(curve, Panel::Stroke::kSolid, series.color);
    panel.add_key(series.color,
                  fmt::format("{}: 95 % within {:#.3g} mm", series.what, quantile(lengths, 0.95)),
                  Panel::Sample::kLine);
  }
  return panel;
}

Panel component_histogram(const std::string& title, const std::vector<TargetResult>& results) {
  const std::vector<double> components =
      components_of(in_mm(error_panel("", results, &TargetResult::after_judged).errors));
  return histogram(title, "error along x and y, mm", components, {rms(components), "their rms"});
}

std::map<std::string, std::vector<Eigen::Vector2d>> ways_of(const std::vector<StepError>& steps) {
  std::map<std::string, std::vector<Eigen::Vector2d>> ways;
  for (const StepError& step : steps) {
    std::vector<Eigen::Vector2d>& way = ways[step.target];
    if (step.step == 0) way.clear();  // what a broken-off run has begun is begun again
    if (step.error) way.emplace_back(step.step, mm(*step.error));
  }
  return ways;
}

Panel way_panel(const std::string& title, const Axis& corrections, const Axis& errors,
                const std::vector<StepError>& steps, const char* color) {
  Panel panel(title, corrections, errors);
  std::vector<double> counts;
  for (const auto& [target, way] : ways_of(steps)) {
    if (way.empty()) continue;
    panel.add_line(way, Panel::Stroke::kSolid, color);
    panel.add_dots(way, {color}, 2.2);
    counts.push_back(way.back().x());
  }
  if (!counts.empty())
    panel.add_note(fmt::format("{} targets, {:g} corrections in the median, {:g} at most",
                               counts.size(), median(counts),
                               *std::max_element(counts.begin(), counts.end())));
  return panel;
}

}  // namespace

std::vector<ReportPlot> control_plots(const ExperimentReport& report) {
  if (error_lengths(report.paper, &TargetResult::before_judged).empty()) return {};
  return {
      paper_plot(18, "the targets of the feedback control",
                 "The desired points of four circles about places beside the base. They reach "
                 "beyond every circle on which the map is checked, so the positioning is a test "
                 "of the map's rim as well.",
                 target_panels(report)),
      paper_plot(19, "errors at the targets before and after feedback",
                 "Every target before feedback and after it, on a scale of "
                 "decades. The four circles follow each other in the order of Table 7. Before "
                 "feedback is where the arm ends by the cell file; on calib/paper that was "
                 "fitted to the paper's means. Look at what the map adds to the paper's chain, "
                 "and whether an error comes back at the same place of each circle.",
                 before_after_panels(report))};
}

std::vector<ReportPlot> coverage_plot(const ExperimentReport& report) {
  if (!report.recorded || report.recorded->training.empty()) return {};
  const auto places = each(report.recorded->training, &PairRow::p_vision);
  const auto targets = each(report.ours, &TargetResult::p_d);
  std::vector<Eigen::Vector2d> all = places;
  all.insert(all.end(), targets.begin(), targets.end());
  Panel panel("Training places and targets", axes_over_places(in_mm(all)));
  panel.add_dots(in_mm(places), {kSeriesColors[0]}, 2.4);
  panel.add_dots(in_mm(targets), {kSeriesColors[1]}, 3.0);
  panel.add_key(kSeriesColors[0], fmt::format("{} training places", places.size()));
  panel.add_key(kSeriesColors[1], fmt::format("{} targets", targets.size()));
  return {ReportPlot{"coverage.svg",
                     "Where the cell was learned and where it was used",
                     "Look for targets far from every training place: there the map continues what "
                     "it learned elsewhere.",
                     {panel}}};
}

std::vector<ReportPlot> spread_plot(const ExperimentReport& report) {
  for (const ErrorSeries& series : series_of(report))
    if (series.lengths_mm().empty()) return {};
  return {ReportPlot{
      "spread.svg",
      "How the errors are spread",
      "First, all four ways of positioning on one scale of decades: a curve further left is "
      "better, a steep one has no stragglers. Then the components of the errors of both chains, "
      "each on a scale of its own, with a normal curve of the same rms: a histogram that "
      "is not about zero has an error in common to many targets.",
      {cumulative_panel(report), component_histogram("The paper's chain", report.paper),
       component_histogram("Ours", report.ours)}}};
}

std::vector<ReportPlot> convergence_plot(const std::vector<StepError>& ours,
                                         const std::vector<StepError>& paper) {
  std::vector<double> errors_mm;
  int most = 1;
  for (const auto* steps : {&ours, &paper})
    for (const StepError& step : *steps) {
      most = std::max(most, step.step);
      if (step.error && *step.error > 0.0) errors_mm.push_back(mm(*step.error));
    }
  if (errors_mm.empty()) return {};
  const Axis corrections{"corrections made", -0.3, most + 0.3};
  const Axis errors = decades_over("error by its own view, mm", errors_mm);
  return {ReportPlot{
      "convergence.svg",
      "How the loop converges at each target",
      "A line for each target: the distance to it as the chain's own compensated vision sees it, "
      "after the first move and after each correction. Both panels have the same axes. A line ends "
      "where the servo is content. Look for lines that rise or last longer than the others. Ours "
      "is aimed by the arm that was found and begins close to the target. What vision cannot see "
      "is not in this figure, but in the errors above.",
      {way_panel("The paper's chain", corrections, errors, paper, kSeriesColors[1]),
       way_panel("Ours", corrections, errors, ours, kSeriesColors[0])}}};
}

}  // namespace planar
