#include "planar_servo/offline/pairs/pair_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/offline/page_of_file.h"
#include "planar_servo/offline/pairs/recording_check.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"

namespace planar {
namespace {

constexpr double kMinute = 60.0;

std::vector<PairRow> attended(const std::vector<PairRow>& pairs) {
  std::vector<PairRow> with_tracker;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(with_tracker),
               [](const PairRow& pair) { return pair.is_attended(); });
  return with_tracker;
}

/// The errors of pairs, over their time where it is known.
Panel series_panel(const std::vector<PairRow>& pairs,
                   const std::vector<Eigen::Vector2d>& errors_mm) {
  const bool timed = std::all_of(pairs.begin(), pairs.end(),
                                 [](const PairRow& pair) { return pair.t_s.has_value(); });
  std::vector<double> at;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    at.push_back(timed ? *pairs[i].t_s / kMinute : static_cast<double>(i + 1));
  const double first = *std::min_element(at.begin(), at.end());
  if (timed)
    for (double& time : at) time -= first;
  return component_panel(
      "The error over time", axis_over(timed ? "time, min" : "pair, in the order of the table", at),
      axis_over("vision minus tracker, mm", components_of(errors_mm)), at, errors_mm);
}

std::string error_plots(const std::vector<PairRow>& pairs, const Summary& raw) {
  const QuiverPanel errors{"Vision minus tracker", each(pairs, &PairRow::p_vision),
                           each(pairs, &PairRow::error)};
  const std::vector<Eigen::Vector2d> errors_mm = in_mm(errors.errors);
  const double rms_mm = mm(raw.rms) / std::sqrt(2.0);
  std::vector<Panel> panels = quiver_panels({errors});
  panels.push_back(series_panel(pairs, errors_mm));
  panels.push_back(histogram("The error's components", "vision minus tracker, mm",
                             components_of(errors_mm), {rms_mm, "their rms"}));
  return plot_html(panels);
}

/// The part of the errors that neither field nor drift explains, and the step that does, dashed.
std::string step_plot(const RecordedStep& step) {
  const ChangePoint& change = step.change;
  const std::vector<Eigen::Vector2d> left_mm = in_mm(change.left);
  const std::vector<double> at =
      each(change.places, [](std::size_t place) { return static_cast<double>(place + 1); });
  const Axis order = axis_over("training place, in the order of time", at);
  Panel panel =
      component_panel(fmt::format("A step from '{}' on", step.id), order,
                      axis_over("what the field leaves, mm", components_of(left_mm)), at, left_mm);
  const double first = static_cast<double>(change.first) + 0.5;
  for (const double size : {change.step.x(), change.step.y()}) {
    const double size_mm = mm(size);
    panel.add_line({{order.from, 0.0}, {first, 0.0}, {first, size_mm}, {order.to, size_mm}},
                   Panel::Stroke::kDashed);
  }
  return plot_html({panel});
}

void list_monuments(ReportList& list, const DatumRegistration& datum) {
  for (const MonumentResidual& monument : datum.residuals) {
    const Eigen::Vector3d off = monument.residual_B / kMillimetre;
    list.row("monuments", {{"monument", monument.id},
                           {"readings", std::to_string(monument.readings)},
                           {"x, mm", fixed(off.x(), 4)},
                           {"y, mm", fixed(off.y(), 4)},
                           {"z, mm", fixed(off.z(), 4)}});
  }
  list.show("monuments", "Monuments: read minus known");
}

void list_fit(ReportList& list, const WorkplaneFit& fit) {
  list.line("workplane",
            "{workplane_absorbed} degrees of freedom fitted to {workplane_places} places, rms "
            "{workplane_rms_mm:.4f} mm",
            fit.absorbed, fit.n_used, fit.rms);
  const std::string reflector =
      fit.tool.reflector_known
          ? "(" + fixed(fit.tool.p_TS.head<2>() / kMillimetre, 4, ", ") + ") mm"
          : "not known";
  list.line("tool", "end point ({p_TP_mm:.4f}) mm, reflector " + reflector, fit.tool.p_TP);
}

void list_clock(ReportList& list, const TrackerClock& clock) {
  ReportList part;
  part.line("clock",
            "the tracker's is {offset_s:.3f} s ahead of the camera's, +- {sigma_offset_s:.3f}, and "
            "runs {rate_ppm:.1f} +- {sigma_rate_ppm:.1f} ppm fast, by {places} places",
            clock.offset_s, clock.sigma_offset_s, clock.rate, clock.sigma_rate, clock.places);
  list.part("clock", part);
}

/// Lists the raw error of the pairs of each plan that has some.
void list_raw_errors(ReportList& list, const std::vector<PairRow>& pairs) {
  ReportList by_plan;
  for (const Purpose plan : values_of(kPurposes)) {
    if (std::none_of(pairs.begin(), pairs.end(),
                     [&](const PairRow& pair) { return pair.is_attended() && pair.plan == plan; }))
      continue;
    const Summary raw = raw_error(pairs, plan);
    ReportList part;
    part.line("raw error",
              std::string(name(plan)) +
                  ": {pairs} pairs, mean {mean_mm:.3f} mm, rms {rms_mm:.3f} mm, max {max_mm:.3f} "
                  "mm",
              raw.n, raw.mean, raw.rms, raw.max);
    by_plan.part(name(plan), part);
  }
  list.part("raw", by_plan);
}

/// Lists what was found with what only the page shows.
ReportList page_list(const PairTrackerRequest& request, const PairTrackerReport& report) {
  ReportList list = pair_tracker_list(report);
  list.line("camera", "{camera_height_mm:.2f} mm above the plane",
            report.workplane.X_WC.translation().z());
  if (const RestSpread spread = rest_spread(request.cell, request.tracker, request.by);
      spread.freedom > 0)
    list.line("readings at rest",
              "spread by {rest_mm:.4f} mm per axis; the cell file states {rest_stated_mm:.4f} mm",
              spread.rms, spread.stated);
  if (report.datum) list_monuments(list, *report.datum);
  list.show("rejected", "Left out");
  return list;
}

}  // namespace

ReportList pair_tracker_list(const PairTrackerReport& report) {
  ReportList list;
  if (report.datum)
    list.line("datum", "{monuments} monuments, rms {datum_rms_mm:.4f} mm",
              report.datum->residuals.size(), report.datum->rms);
  else
    list.line("datum", "no tracker reading: place and turn are those of the commanded arm");
  list_fit(list, report.workplane);
  list.line("lamps", "eccentricity of their discs up to {eccentricity_px_max:.4f} px, taken off",
            report.largest_eccentricity_px);
  if (report.clock) list_clock(list, *report.clock);
  const auto list_rejected = [](ReportList& row, const Rejection& rejection) {
    row.line("place", "{id}", rejection.id);
    row.line("why", "{reason}", rejection.reason);
  };
  list.rows("rejected", report.rejected, list_rejected, "rejected            ");
  list.unprinted("doubts", each(report.doubts, &Refusal::text));
  const auto n = static_cast<std::size_t>(
      std::count_if(report.pairs.begin(), report.pairs.end(),
                    [](const PairRow& pair) { return !pair.is_attended(); }));
  list.unprinted("pairs", report.pairs.size() - n);
  if (report.datum) {
    const Summary raw = raw_error(report.pairs);
    list.unprinted("p_TS_mm", report.workplane.tool.p_TS);
    list.unprinted("raw_mean_mm", raw.mean);
    list.unprinted("raw_rms_mm", raw.rms);
    list_raw_errors(list, report.pairs);
  }
  list.line_if(n > 0, "unattended", "{unattended} poses that only the camera watched", n);
  return list;
}

Verdict pair_verdict(const PairTrackerRequest& request, const PairTrackerReport& report) {
  Verdict verdict;
  for (const Refusal& doubt : report.doubts)
    verdict.doubt(doubt.fault,
                  doubt.remedy.empty() ? "look at it before you use the pairs" : doubt.remedy);
  doubt_left_out(report.rejected.size(), report.pairs.size() + report.rejected.size(),
                 "places were", verdict);
  if (!verdict.faults.empty()) return verdict;
  const std::vector<PairRow> pairs = attended(report.pairs);
  if (!report.datum || pairs.empty()) {
    verdict.good =
        fmt::format("{} poses were seen; no tracker reading judges them", report.pairs.size());
    return verdict;
  }
  const Summary raw = raw_error(report.pairs);
  verdict.good = fmt::format(
      "{} pairs; the monuments are met to {:.4f} mm, where the tracker's deviation is {:.4f} mm "
      "per axis, and vision without a map is {:.4f} mm off on average",
      pairs.size(), mm(report.datum->rms), mm(request.cell.tracker.sigma_m), mm(raw.mean));
  return verdict;
}

std::string pair_page(const PairTrackerRequest& request, const PairTrackerReport& report,
                      const std::filesystem::path& file) {
  HtmlPage page = page_about("Pairs", file, pair_verdict(request, report));
  const std::vector<PairRow> pairs = attended(report.pairs);
  if (!pairs.empty())
    page.add_section(
        "Vision minus tracker", error_plots(pairs, raw_error(report.pairs)),
        "First: from each place, the error of vision there, which the error map is to learn; "
        "neighbours should point the same way. A line that differs from all around it is a wrong "
        "pair. Second: a step or a trend over time means that the camera, a monument or the "
        "tracker has moved.");
  if (report.step)
    page.add_section(
        "A step in time", step_plot(*report.step),
        fmt::format("The training places without the field and its slow drift{}. The dashed step "
                    "costs up to {:.3f} mm at the end point. Where nothing has moved, the dots "
                    "scatter about zero all along.",
                    report.step->change.frame == StepFrame::kTool ? ", in the tool's frame" : "",
                    mm(report.step->cost())));
  return ended_page(std::move(page), page_list(request, report), file);
}

}  // namespace planar
