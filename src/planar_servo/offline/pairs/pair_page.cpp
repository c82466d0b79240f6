#include "planar_servo/offline/pairs/pair_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/offline/page/page_of_file.h"
#include "planar_servo/offline/pairs/recording_check.h"
#include "planar_servo/report/figure/figure.h"
#include "planar_servo/report/figure/places.h"
#include "planar_servo/report/quiver_figure.h"
#include "planar_servo/report/text_table.h"

namespace planar {
namespace {

constexpr double kMinute = 60.0;

/// Makes a fault of a doubt, whose words end with what to do, behind a semicolon.
Verdict::Fault fault_of(const std::string& doubt) {
  const std::size_t end = doubt.rfind("; ");
  if (end == std::string::npos) return {doubt, "look at it before you use the pairs"};
  return {doubt.substr(0, end), doubt.substr(end + 2)};
}

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

std::string error_figures(const std::vector<PairRow>& pairs, const Summary& raw) {
  QuiverPanel errors{"Vision minus tracker", {}, {}};
  for (const PairRow& pair : pairs) {
    errors.points.push_back(pair.p_vision);
    errors.errors.push_back(pair.error());
  }
  const std::vector<Eigen::Vector2d> mm = in_mm(errors.errors);
  const double rms_mm = raw.rms / kMillimetre / std::sqrt(2.0);
  std::vector<Panel> panels = quiver_panels({errors});
  panels.push_back(series_panel(pairs, mm));
  return figure_svg(panels) +
         figure_svg({histogram("The error's components", "vision minus tracker, mm",
                               components_of(mm), {rms_mm, "their rms"})});
}

/// What neither field nor drift explains of the errors, and the step that does, dashed.
std::string step_figure(const RecordedStep& step) {
  const ChangePoint& change = step.change;
  const std::vector<Eigen::Vector2d> left_mm = in_mm(change.left);
  std::vector<double> at;
  for (const std::size_t place : change.places) at.push_back(static_cast<double>(place + 1));
  const Axis order = axis_over("training place, in the order of time", at);
  Panel panel =
      component_panel(fmt::format("A step from '{}' on", step.id), order,
                      axis_over("what the field leaves, mm", components_of(left_mm)), at, left_mm);
  const double first = static_cast<double>(change.first) + 0.5;
  for (const double size : {change.step.x(), change.step.y()}) {
    const double size_mm = size / kMillimetre;
    panel.add_line({{order.from, 0.0}, {first, 0.0}, {first, size_mm}, {order.to, size_mm}},
                   Panel::Stroke::kDashed);
  }
  return figure_svg({panel});
}

TextTable monument_table(const DatumRegistration& datum) {
  TextTable table("Monuments: read minus known",
                  {"monument", "readings", "x, mm", "y, mm", "z, mm"});
  for (const MonumentResidual& monument : datum.residuals) {
    const Eigen::Vector3d off = monument.residual_B / kMillimetre;
    table.add_row({monument.id, std::to_string(monument.readings), fixed(off.x(), 4),
                   fixed(off.y(), 4), fixed(off.z(), 4)});
  }
  return table;
}

TextTable fit_table(const PairTrackerRequest& request, const PairTrackerReport& report) {
  const WorkplaneFit& fit = report.workplane;
  TextTable table("What was found", {"", ""});
  table.add_row({"places of the workplane's fit", std::to_string(fit.n_used)});
  table.add_row({"its rms, mm", fixed(fit.rms / kMillimetre, 4)});
  table.add_row({"height of the camera, mm", fixed(fit.X_WC.translation().z() / kMillimetre, 2)});
  table.add_row({"end point in the tool's frame, mm", fixed(fit.tool.p_TP / kMillimetre, 4, ", ")});
  if (fit.tool.reflector_known)
    table.add_row({"reflector in the tool's frame, mm",
                   fixed(fit.tool.p_TS.head<2>() / kMillimetre, 4, ", ")});
  if (report.datum)
    table.add_row({"monuments, rms, mm", fixed(report.datum->rms / kMillimetre, 4)});
  if (const RestSpread spread = rest_spread(request); spread.freedom > 0) {
    table.add_row({"spread of readings at rest per axis, mm", fixed(spread.rms / kMillimetre, 4)});
    table.add_row({"what the cell file states for it, mm", fixed(spread.stated / kMillimetre, 4)});
  }
  if (report.clock) {
    table.add_row({"tracker's clock ahead of the camera's, s", fixed(report.clock->offset_s, 3)});
    table.add_row({"and fast by, ppm", fixed(1e6 * report.clock->rate, 1)});
  }
  return table;
}

}  // namespace

Verdict pair_verdict(const PairTrackerRequest& request, const PairTrackerReport& report) {
  Verdict verdict;
  for (const std::string& doubt : report.doubts) verdict.faults.push_back(fault_of(doubt));
  const std::size_t places = report.pairs.size() + report.rejected.size();
  if (static_cast<double>(report.rejected.size()) > kFewLeftOut * static_cast<double>(places))
    verdict.faults.push_back(
        {fmt::format("{} of {} places were left out", report.rejected.size(), places),
         "look at the images and readings under 'Left out', which says why, and record these "
         "places again"});
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
      "per axis, and vision without a map is {:.4f} mm off in the mean",
      pairs.size(), report.datum->rms / kMillimetre, request.cell.tracker.sigma_m / kMillimetre,
      raw.mean / kMillimetre);
  return verdict;
}

std::string pair_page(const PairTrackerRequest& request, const PairTrackerReport& report,
                      const std::filesystem::path& file) {
  HtmlPage page = page_about("Pairs", file);
  page.add_verdict(pair_verdict(request, report));
  const std::vector<PairRow> pairs = attended(report.pairs);
  if (!pairs.empty()) {
    page.add_html(error_figures(pairs, raw_error(report.pairs)));
    page.add_paragraph(
        "Left: from each place, the error of vision there, which the error map is to learn; "
        "neighbours should point the same way. A line that differs from all around it is a wrong "
        "pair. Right: a step or a trend over time means that the camera, a monument or the tracker "
        "has moved.");
  }
  if (report.step) {
    page.add_html(step_figure(*report.step));
    page.add_paragraph(fmt::format(
        "The training places without the field and its slow drift{}. The dashed step costs up to "
        "{:.3f} mm at the end point. Where nothing has moved, the dots scatter about zero all "
        "along.",
        report.step->change.frame == StepFrame::kTool ? ", in the tool's frame" : "",
        report.step->cost() / kMillimetre));
  }
  page.add_html(fit_table(request, report).html());
  if (report.datum) page.add_html(monument_table(*report.datum).html());
  if (!report.rejected.empty()) {
    TextTable rejected("Left out", {"place", "why"});
    for (const Rejection& rejection : report.rejected)
      rejected.add_row({rejection.id, rejection.reason});
    page.add_html(rejected.html());
  }
  add_provenance(page, file);
  return page.text();
}

}  // namespace planar
