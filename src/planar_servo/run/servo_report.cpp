#include "planar_servo/run/servo_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/core/text.h"
#include "planar_servo/core/units.h"
#include "planar_servo/devices/judge.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/yaml_writer.h"
#include "planar_servo/report/text_table.h"

namespace planar {
namespace {

std::optional<Summary> summary_of(const std::vector<TargetResult>& results, TargetError error) {
  const std::vector<double> lengths = error_lengths(results, error);
  if (lengths.empty()) return std::nullopt;
  return summarize(lengths);
}

std::optional<double> coverage_of(const std::vector<TargetResult>& results) {
  constexpr double kSigmas = 1.96;
  Eigen::Index within = 0, all = 0;
  for (const TargetResult& result : results) {
    const auto& believed = result.believed ? result.believed : result.vision_compensated;
    if (!believed || !result.uncertainty_m) continue;
    const double sigma = std::hypot(*result.uncertainty_m, result.sigma_truth_m.value_or(0.0));
    within += (believed->array().abs() < kSigmas * sigma).count();
    all += 2;
  }
  if (all == 0) return std::nullopt;
  return static_cast<double>(within) / static_cast<double>(all);
}

/// Returns whether vision made the true errors longer in the mean, by more than two standard
/// deviations of that mean.
bool made_worse(const std::vector<TargetResult>& results) {
  constexpr std::size_t kEnoughTargets = 5;
  constexpr double kSigmas = 2.0;
  std::vector<double> changes;
  for (const TargetResult& result : results)
    if (result.before_truth && result.after_truth)
      changes.push_back(result.after_truth->norm() - result.before_truth->norm());
  if (changes.size() < kEnoughTargets) return false;
  const auto n = static_cast<double>(changes.size());
  const double change = mean(changes);
  const double variance = (rms(changes) * rms(changes) - change * change) / (n - 1.0);
  return change > kSigmas * std::sqrt(std::max(0.0, variance));
}

std::optional<TrackerFigures> tracker_figures(const std::vector<TargetResult>& results) {
  TrackerFigures figures;
  double squares = 0.0, variances = 0.0;
  for (const TargetResult& result : results) {
    if (!result.not_judged.empty()) figures.not_judged.emplace_back(result.id, result.not_judged);
    if (!result.sigma_truth_m || !result.after_truth) continue;
    ++figures.judged;
    squares += result.after_truth->squaredNorm();
    variances += *result.sigma_truth_m * *result.sigma_truth_m;
  }
  if (figures.judged == 0 && figures.not_judged.empty()) return std::nullopt;
  const double n = static_cast<double>(std::max<std::size_t>(figures.judged, 1));
  figures.sigma = std::sqrt(variances / n);
  figures.after_net = std::sqrt(std::max(0.0, (squares - 2.0 * variances) / n));
  return figures;
}

void list_errors(ReportList& list, const std::string& judge, const std::optional<Summary>& before,
                 const std::optional<Summary>& after) {
  if (!before || !after) return;
  list.line("",
            judge +
                ": the arm alone {before_mean_mm:.4f} mm mean; with vision {after_mean_mm:.4f} mm "
                "mean, {after_rms_mm:.4f} rms, {after_p95_mm:.4f} at 95 %, {after_max_mm:.4f} max",
            before->mean, after->mean, after->rms, after->p95, after->max);
  list.unprinted("improvement", 1.0 - after->mean / before->mean);
}

std::string judge_name(const ServoFigures& figures) {
  return name_in(kJudgeKinds, figures.tracker ? JudgeKind::kTracker : JudgeKind::kTruth);
}

/// Lists what the judge told, `list_told(list, figures)`, under keys that end with who it was.
/// For one version those of a tracker stand under `_truth`, too.
template <typename ListTold>
void list_judged(ReportList& list, const ServoFigures& figures, ListTold list_told) {
  ReportList told("_" + judge_name(figures)), as_before("_truth");
  list_told(told, figures);
  list_told(as_before, figures);
  list.append(told);
  list.append_figures(as_before);
}

void list_judged_errors(ReportList& list, const ServoFigures& figures) {
  list_errors(list, "against the " + judge_name(figures), figures.before_truth,
              figures.after_truth);
}

void list_tracker_sigma(ReportList& list, const ServoFigures& figures) {
  list.line("",
            "the tracker's word is known to {sigma_mm:.4f} mm per axis; with that taken out: after "
            "{after_rms_net_mm:.4f} rms",
            figures.tracker->sigma, figures.tracker->after_net);
}

void list_coverage(ReportList& list, const ServoFigures& figures) {
  list.line("", "vision: {coverage_95:.1%} of the components within their stated 95 % interval",
            figures.coverage_95);
}

void list_tracker(ReportList& list, const ServoFigures& figures) {
  const TrackerFigures& tracker = *figures.tracker;
  list.unprinted("judged", tracker.judged);
  if (tracker.judged > 0) list_judged(list, figures, list_tracker_sigma);
  const auto list_not_judged = [](ReportList& row, const auto& not_judged) {
    row.line("target", "{target}", not_judged.first);
    row.line("why", "{reason}", not_judged.second);
  };
  list.rows("not_judged", tracker.not_judged, list_not_judged, "not judged: ");
}

constexpr char kMadeWorse[] = "vision made the arm worse than it lands alone";

std::string coverage_words(const ServoFigures& figures) {
  constexpr double kLeast = 0.90, kMost = 0.98;
  if (!figures.coverage_95) return "";
  const double share = *figures.coverage_95;
  if (share >= kLeast && share <= kMost) return "";
  return fmt::format("; the stated 95 % intervals hold {:.1f} % of the components: they are too {}",
                     100.0 * share, share < kLeast ? "narrow" : "wide");
}

std::string error_words(const std::optional<Eigen::Vector2d>& error) {
  return error ? fmt::format("{:.4f}", mm(error->norm())) : "–";
}

/// Returns the text of run.yaml: the files used with their hashes, settings and outcome.
std::string run_text(const ServoRequest& request, const ServoRun& run, const ServoFigures& figures,
                     const std::vector<std::filesystem::path>& inputs) {
  YamlWriter yaml("run", "planar-servo");
  yaml.add_inputs(input_records(inputs));
  yaml.add("error_map_used", request.use_error_map);
  if (!run.accepted_stale().empty()) yaml.add("accepted_stale", run.accepted_stale());
  if (run.accepted_map()) yaml.add("accepted_map", *run.accepted_map());
  yaml.add("targets", static_cast<int>(figures.targets));
  yaml.add("reached", static_cast<int>(figures.reached));
  if (figures.frames) yaml.add("camera", describe(*figures.frames));
  yaml.map("figures", [&] {
    const ReportList list = servo_list(figures);
    for (const auto& [key, value] : list.json().items())
      if (value.is_number_float()) yaml.add(key, value.get<double>());
  });
  return yaml.text();
}

}  // namespace

std::vector<double> error_lengths(const std::vector<TargetResult>& results, TargetError error) {
  std::vector<double> lengths;
  for (const TargetResult& result : results)
    if (result.*error) lengths.push_back((result.*error)->norm());
  return lengths;
}

double mean_error(const std::vector<TargetResult>& results, TargetError error) {
  const std::vector<double> lengths = error_lengths(results, error);
  return lengths.empty() ? std::numeric_limits<double>::quiet_NaN() : mean(lengths);
}

ServoFigures figures_of(const std::vector<TargetResult>& results) {
  ServoFigures figures;
  figures.targets = results.size();
  std::vector<double> iterations, seconds;
  for (const TargetResult& result : results) {
    if (result.status == ServoStatus::kReached) ++figures.reached;
    iterations.push_back(result.iterations);
    seconds.push_back(result.seconds);
  }
  if (results.empty()) return figures;
  figures.iterations_median = median(iterations);
  figures.seconds_per_target = mean(seconds);
  figures.before_own = summary_of(results, &TargetResult::before_own);
  figures.after_own = summary_of(results, &TargetResult::after_own);
  figures.before_truth = summary_of(results, &TargetResult::before_truth);
  figures.after_truth = summary_of(results, &TargetResult::after_truth);
  figures.coverage_95 = coverage_of(results);
  figures.made_worse = made_worse(results);
  figures.tracker = tracker_figures(results);
  return figures;
}

QuiverPanel error_panel(const std::string& what, const std::vector<TargetResult>& results,
                        TargetError error) {
  QuiverPanel panel;
  panel.title = fmt::format("{}: {:#.3g} mm mean", what, mm(mean_error(results, error)));
  for (const TargetResult& result : results) {
    if (!(result.*error)) continue;
    panel.points.push_back(result.p_d);
    panel.errors.push_back(*(result.*error));
  }
  return panel;
}

ReportList servo_list(const ServoFigures& figures) {
  ReportList list;
  list.line("",
            fmt::format("{{reached}} of {{targets}} targets reached, {{iterations_median:g}} "
                        "correction{} and {{seconds_per_target:.2f}} s each",
                        figures.iterations_median == 1.0 ? "" : "s"),
            figures.reached, figures.targets, figures.iterations_median,
            figures.seconds_per_target);
  list_judged(list, figures, list_judged_errors);
  if (figures.made_worse) list.line("", kMadeWorse);
  if (figures.tracker) list_tracker(list, figures);
  ReportList own_view("_own_view");
  list_errors(own_view, "by its own view", figures.before_own, figures.after_own);
  list.append(own_view);
  list_judged(list, figures, list_coverage);
  if (!figures.frames) return list;
  list.line("", "camera: " + describe(*figures.frames));
  list.unprinted("frames_complete", figures.frames->complete);
  list.unprinted("frames_incomplete", figures.frames->incomplete);
  list.unprinted("frames_frozen", figures.frames->frozen);
  list.unprinted("camera_reopened", figures.frames->reopened);
  return list;
}

std::string landing_words(const ServoFigures& figures) {
  const bool is_judged = figures.before_truth && figures.after_truth;
  const auto& before = is_judged ? figures.before_truth : figures.before_own;
  const auto& after = is_judged ? figures.after_truth : figures.after_own;
  if (!before || !after) return "";
  return fmt::format(
      "{} the arm alone lands {:.4f} mm from its targets in the mean, with vision "
      "{:.4f} mm{}",
      is_judged ? "against the " + judge_name(figures) : "by its own view", mm(before->mean),
      mm(after->mean), coverage_words(figures));
}

std::vector<Verdict::Fault> run_faults(const ServoFigures& figures, const std::string& results) {
  std::vector<Verdict::Fault> faults;
  if (figures.reached < figures.targets)
    faults.push_back({fmt::format("{} of {} targets were not reached",
                                  figures.targets - figures.reached, figures.targets),
                      results + " has the reason of each"});
  if (figures.made_worse)
    faults.push_back({kMadeWorse,
                      "planar-check-cell says what has moved since the calibration; if nothing "
                      "has, record more training places and fit the error map again"});
  return faults;
}

std::string servo_page(const ServoRequest& request, const std::vector<TargetResult>& results) {
  HtmlPage page("planar-servo: " + request.cell.file.filename().string());
  const ServoFigures figures = figures_of(results);
  if (const std::string words = landing_words(figures); !words.empty())
    page.add_verdict({words, run_faults(figures, "the table below")});
  page.add_paragraph(servo_list(figures).text());
  const bool is_judged = figures.before_truth || figures.after_truth;
  const QuiverPanel before =
      error_panel("The arm alone", results,
                  is_judged ? &TargetResult::before_truth : &TargetResult::before_own);
  const QuiverPanel after = error_panel(
      "With vision", results, is_judged ? &TargetResult::after_truth : &TargetResult::after_own);
  page.add_heading(is_judged ? "Errors against the " + judge_name(figures)
                             : "Errors by the servo's own view");
  if (!before.points.empty()) {
    page.add_html(quiver_svg({before, after}));
    page.add_paragraph(kQuiverCaption);
    page.add_html(quiver_svg({after}));
    page.add_paragraph("The last panel once more, at scales of its own.");
  }
  TextTable table("Targets", {"target", "x mm", "y mm", "status", "corrections", "own view mm",
                              "uncertainty mm", judge_name(figures) + " mm"});
  for (const TargetResult& r : results)
    table.add_row({r.id, fixed(mm(r.p_d.x()), 3), fixed(mm(r.p_d.y()), 3),
                   r.reason.empty() ? name(r.status) : name(r.status) + (": " + r.reason),
                   std::to_string(r.iterations), error_words(r.after_own),
                   r.uncertainty_m ? fmt::format("{:.4f}", mm(*r.uncertainty_m)) : "–",
                   error_words(r.after_truth)});
  page.add_html(table.html());
  return page.text();
}

std::vector<std::filesystem::path> run_inputs(const ServoRequest& request,
                                              const std::filesystem::path& wanted) {
  const CellSettings& cell = request.cell;
  std::vector<std::filesystem::path> inputs{cell.file, cell.camera_model, cell.workplane,
                                            cell.tool};
  if (!wanted.empty()) inputs.push_back(wanted);
  if (request.use_error_map) inputs.push_back(cell.error_map);
  if (cell.arm_found) inputs.push_back(*cell.arm_found);
  return inputs;
}

void write_run(const ServoRequest& request, const ServoRun& run, const ServoFigures& figures,
               const std::filesystem::path& targets) {
  if (!run.has_new_results() && std::filesystem::exists(request.out / "run.yaml")) return;
  write_file(request.out / "run.yaml",
             run_text(request, run, figures, run_inputs(request, targets)));
  write_file(request.out / "report.html", servo_page(request, run.results()));
}

}  // namespace planar
