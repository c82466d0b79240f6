#include "planar_servo/work/run/servo_report.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/columns.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/places.h"
#include "planar_servo/work/run/run_files.h"

namespace planar {

namespace {

std::optional<Summary> summary_of(const std::vector<TargetResult>& results, TargetError error) {
  const std::vector<double> lengths = error_lengths(results, error);
  if (lengths.empty()) return std::nullopt;
  return summarize(lengths);
}

std::optional<Coverage> coverage_of(const std::vector<TargetResult>& results) {
  constexpr double kSigmas = 1.96;
  Coverage coverage;
  for (const TargetResult& result : results) {
    const auto& believed = result.believed ? result.believed : result.vision_compensated;
    if (!believed || !result.uncertainty_m) continue;
    // The judge knows where the base frame is, not where the work lies in it.
    const double own_m = std::sqrt(
        std::max(0.0, std::pow(*result.uncertainty_m, 2) - std::pow(result.sigma_target_m, 2)));
    const double sigma = std::hypot(own_m, result.sigma_judged_m.value_or(0.0));
    coverage.within += static_cast<int>((believed->array().abs() < kSigmas * sigma).count());
    coverage.all += 2;
  }
  if (coverage.all == 0) return std::nullopt;
  return coverage;
}

/// Returns whether vision made the true errors longer on average, by more than two standard
/// deviations of the mean.
bool made_worse(const std::vector<TargetResult>& results) {
  constexpr std::size_t kEnoughTargets = 5;
  constexpr double kSigmas = 2.0;
  std::vector<double> changes;
  for (const TargetResult& result : results)
    if (result.before_judged && result.after_judged)
      changes.push_back(result.after_judged->norm() - result.before_judged->norm());
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
    if (!result.sigma_judged_m || !result.after_judged) continue;
    ++figures.judged;
    squares += result.after_judged->squaredNorm();
    variances += *result.sigma_judged_m * *result.sigma_judged_m;
  }
  if (figures.judged == 0 && figures.not_judged.empty()) return std::nullopt;
  const double n = static_cast<double>(std::max<std::size_t>(figures.judged, 1));
  figures.sigma = std::sqrt(variances / n);
  figures.after_net = std::sqrt(std::max(0.0, (squares - 2.0 * variances) / n));
  return figures;
}

/// The same figures as a line of print and as a sentence of a page, each behind who judged.
constexpr char kErrorLine[] =
    ": the arm alone {before_mean_mm:.4f} mm mean; with vision {after_mean_mm:.4f} mm mean, "
    "{after_rms_mm:.4f} rms, {after_p95_mm:.4f} at 95 %, {after_max_mm:.4f} max";
constexpr char kErrorSentence[] =
    ", the arm alone landed {before_mean_mm:.4f} mm from its targets on average, with vision "
    "{after_mean_mm:.4f} mm ({after_rms_mm:.4f} mm rms, {after_p95_mm:.4f} mm at 95 %, "
    "{after_max_mm:.4f} mm at most)";

void list_errors(ReportList& list, const std::string& text, const std::optional<Summary>& before,
                 const std::optional<Summary>& after) {
  if (!before || !after) return;
  list.line("", text, before->mean, after->mean, after->rms, after->p95, after->max);
  list.unprinted("improvement", 1.0 - after->mean / before->mean);
}

/// Lists the judge's figures, `list_told(list, figures)`, under keys that end with its name. For
/// one version those of a tracker stand under `_truth`, too.
template <typename ListTold>
void list_judged(ReportList& list, const ServoFigures& figures, ListTold list_told) {
  ReportList told("_" + figures.judge()), as_before("_truth");
  list_told(told, figures);
  list_told(as_before, figures);
  list.append(told);
  list.append_figures(as_before);
}

void list_judged_errors(ReportList& list, const ServoFigures& figures) {
  list_errors(list, "against the " + figures.judge() + kErrorLine, figures.before_judged,
              figures.after_judged);
}

void list_tracker_sigma(ReportList& list, const ServoFigures& figures) {
  const double sigma = figures.tracker->sigma, net = figures.tracker->after_net;
  if (net > 0.0)
    return list.line("",
                     "the tracker is uncertain by {sigma_mm:.4f} mm per axis; without that the "
                     "errors with vision are {after_rms_net_mm:.4f} mm rms",
                     sigma, net);
  list.line("",
            "the tracker is uncertain by {sigma_mm:.4f} mm per axis, which explains the errors "
            "with vision",
            sigma);
  list.unprinted("after_rms_net_mm", net);
}

void list_coverage(ReportList& list, const ServoFigures& figures) {
  list.line("", "vision: {coverage_95:.1%} of the components within their stated 95 % interval",
            figures.coverage_95 ? std::optional(figures.coverage_95->share()) : std::nullopt);
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

/// Names intervals that hold too little or too much, unless that few components may do so by
/// chance.
std::string coverage_words(const ServoFigures& figures) {
  constexpr double kLeast = 0.90, kMost = 0.98, kStated = 0.95;
  if (!figures.coverage_95) return "";
  const auto [within, all] = *figures.coverage_95;
  const double share = figures.coverage_95->share();
  if (share < kLeast && binomial_tail(within, all, kStated) < kFalseAlarm)
    return "; the stated 95 % intervals are too narrow";
  if (share > kMost && binomial_tail(all - within, all, 1.0 - kStated) < kFalseAlarm)
    return "; the stated 95 % intervals are wider than need be";
  return "";
}

ReportList reached_list(const ServoFigures& figures) {
  ReportList list;
  list.line("",
            fmt::format("{{reached}} of {{targets}} targets reached, {{iterations_median:g}} "
                        "correction{} and {{seconds_per_target:.2f}} s each",
                        figures.iterations_median == 1.0 ? "" : "s"),
            figures.reached, figures.targets, figures.iterations_median,
            figures.seconds_per_target);
  return list;
}

void list_own_view(ReportList& list, const ServoFigures& figures) {
  ReportList own_view("_own_view");
  list_errors(own_view, std::string("by its own view") + kErrorLine, figures.before_own,
              figures.after_own);
  list.append(own_view);
}

void list_frames(ReportList& list, const FrameCounts& frames) {
  list.line("", "camera: " + describe(frames));
  list.unprinted("frames_complete", frames.complete);
  list.unprinted("frames_incomplete", frames.incomplete);
  list.unprinted("frames_frozen", frames.frozen);
  list.unprinted("camera_reopened", frames.reopened);
}

/// Lists the figures other than the targets reached and the judged errors.
ReportList other_list(const ServoFigures& figures) {
  ReportList list;
  if (figures.tracker) list_tracker(list, figures);
  if (figures.is_judged()) list_own_view(list, figures);
  list_judged(list, figures, list_coverage);
  if (figures.frames) list_frames(list, *figures.frames);
  return list;
}

/// Returns the one line of a list without its end.
std::string line_of(const ReportList& list) {
  const std::string text = list.text();
  return text.substr(0, text.find('\n'));
}

/// Returns the text of run.yaml: what was used, and the outcome.
std::string run_text(const ServoRequest& request, const ServoRun& run, const ServoFigures& figures,
                     const std::filesystem::path& targets) {
  YamlWriter yaml("run", "planar-servo");
  add_used(yaml, request, run.cell(), targets);
  yaml.add("targets", static_cast<int>(figures.targets));
  yaml.add("reached", static_cast<int>(figures.reached));
  if (figures.frames) yaml.add("camera", describe(*figures.frames));
  yaml.map("figures", [&] {
    const ReportList list = servo_list(figures);
    for (const auto& [key, value] : list.json().items())
      if (value.is_number()) yaml.add(key, value.get<double>());
  });
  return yaml.text();
}

void log_failures(const ServoRun& run) {
  std::size_t doubted = 0;
  for (const TargetResult& result : run.results()) {
    if (result.status == ServoStatus::kDoubted)
      ++doubted;
    else if (result.status != ServoStatus::kReached)
      spdlog::warn(fmt::format("{}: {}: {}", result.id, name(result.status), result.reason));
  }
  if (doubted > 0)
    spdlog::warn(
        fmt::format("targets doubted: {}, which were reached after the last good check{}", doubted,
                    run.work_has_moved() ? "" : " of the cell; --resume visits them again"));
  if (run.ended_by())
    spdlog::error("no further target was tried: " +
                  early_end(*run.ended_by(), run.work_has_moved()).text());
}

/// Arrows with a mean this much shorter than that of others are invisible at their scale.
constexpr double kComparable = 0.1;

/// Draws where the arm alone and where vision left the end point: at one scale, unless one of them
/// would not be seen.
void add_error_plots(HtmlPage& page, const ServoFigures& figures,
                     const std::vector<TargetResult>& results) {
  const bool judged = figures.is_judged();
  QuiverPanel alone =
      error_panel("", results, judged ? &TargetResult::before_judged : &TargetResult::before_own);
  QuiverPanel seeing =
      error_panel("", results, judged ? &TargetResult::after_judged : &TargetResult::after_own);
  if (alone.points.empty() || seeing.points.empty()) return;
  alone.title = "The arm alone";
  seeing.title = "With vision";
  const double ratio = judged ? figures.after_judged->mean / figures.before_judged->mean
                              : figures.after_own->mean / figures.before_own->mean;
  const bool at_one_scale = ratio > kComparable && ratio * kComparable < 1.0;
  page.add_section(
      judged ? "Errors against the " + figures.judge() : "Errors by vision's own estimate",
      at_one_scale ? plot_html(quiver_panels({alone, seeing}))
                   : plot_html(quiver_panels({alone})) + plot_html(quiver_panels({seeing})),
      std::string("Each line leads from a target in the direction of its error; the bar below "
                  "gives the scale. ") +
          (at_one_scale ? "Both panels have the same scale and colours."
                        : "The errors differ so much that each panel has its own scale."));
}

/// Returns a table of columns of results.csv.
std::string target_table(const ServoFigures& figures, const std::vector<TargetResult>& results) {
  std::vector<ShownColumn> shown{
      {"target"},           {"x_mm", 3}, {"y_mm", 3}, {"iterations"}, {"after_own_view_mm", 4},
      {"uncertainty_mm", 4}};
  if (figures.is_judged()) shown.push_back({"after_" + figures.judge() + "_mm", 4});
  shown.insert(shown.end(), {{"status"}, {"reason"}});
  ReportList list;
  for (const TargetResult& result : results) list.row("targets", result_columns(result), shown);
  list.show("targets", "Distance from each target at the end");
  return list.table_html("targets");
}

Verdict servo_verdict(const ServoFigures& figures, const std::optional<Refusal>& end) {
  Verdict verdict{reached_words(figures), run_faults(figures, "the table below"),
                  landing_words(figures)};
  if (end) verdict.faults.push_back(*end);
  if (verdict.found.empty())
    verdict.found = "No end point was measured";
  else if (!figures.is_judged())
    verdict.found +=
        ". Nobody else judged this run, and vision cannot see what its calibration "
        "gets wrong: on a cell with a tracker, --judged measures every target";
  if (!verdict.faults.empty()) verdict.found = verdict.good + ". " + verdict.found;
  return verdict;
}

}  // namespace

Refusal early_end(const std::string& ended_by, bool work_has_moved) {
  return {"the run was ended at " + ended_by,
          work_has_moved ? ""
                         : "mend the cell (planar-check-cell says what has changed), then continue "
                           "with --resume",
          "", Cause::kContradiction};
}

std::string ServoFigures::judge() const {
  return name_in(kJudgeKinds, tracker ? JudgeKind::kTracker : JudgeKind::kTruth);
}

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
  for (const TargetResult& result : results)
    if (result.status == ServoStatus::kReached) ++figures.reached;
  if (results.empty()) return figures;
  figures.iterations_median =
      median(each(results, [](const TargetResult& result) { return 1.0 * result.iterations; }));
  figures.seconds_per_target = mean(each(results, &TargetResult::seconds));
  figures.before_own = summary_of(results, &TargetResult::before_own);
  figures.after_own = summary_of(results, &TargetResult::after_own);
  figures.before_judged = summary_of(results, &TargetResult::before_judged);
  figures.after_judged = summary_of(results, &TargetResult::after_judged);
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
  ReportList list = reached_list(figures);
  list_judged(list, figures, list_judged_errors);
  if (figures.made_worse) list.line("", kMadeWorse);
  if (!figures.is_judged()) list_own_view(list, figures);
  list.append(other_list(figures));
  return list;
}

std::string reached_words(const ServoFigures& figures) {
  return line_of(reached_list(figures));
}

std::string landing_words(const ServoFigures& figures) {
  const bool judged = figures.is_judged();
  const std::string judge = !judged           ? "By vision's own estimate"
                            : figures.tracker ? "Judged by the tracker"
                                              : "Judged by the truth of the virtual cell";
  ReportList list;
  list_errors(list, judge + kErrorSentence, judged ? figures.before_judged : figures.before_own,
              judged ? figures.after_judged : figures.after_own);
  const std::string words = line_of(list);
  return words.empty() ? "" : words + coverage_words(figures);
}

std::vector<Refusal> run_faults(const ServoFigures& figures, const std::string& results) {
  std::vector<Refusal> faults;
  if (figures.reached < figures.targets)
    faults.push_back({fmt::format("{} of {} targets were not reached",
                                  figures.targets - figures.reached, figures.targets),
                      results + " has the reason of each", "", Cause::kInsufficient});
  if (figures.made_worse)
    faults.push_back({kMadeWorse,
                      "planar-check-cell says what has moved since the calibration; if nothing "
                      "has, record more training places and fit the error map again",
                      "", Cause::kContradiction});
  return faults;
}

void add_used(YamlWriter& yaml, const ServoRequest& request, const ReadyCell& cell,
              const std::filesystem::path& wanted) {
  std::vector<std::filesystem::path> files{cell.settings().file};
  if (!wanted.empty()) files.push_back(wanted);
  if (request.works) files.push_back(request.works->file);
  std::vector<InputRecord> inputs = input_records(files);
  for (InputRecord& made : input_records(run_origins(request))) inputs.push_back(std::move(made));
  yaml.add_inputs(inputs);
  yaml.add("error_map_used", uses_error_map(*request.cell));
  if (!cell.accepted_stale().empty()) yaml.add("accepted_stale", cell.accepted_stale());
  if (cell.accepted_map()) yaml.add("accepted_map", *cell.accepted_map());
  const auto features = cell.camera().features();
  if (!features.empty())
    yaml.map("camera_features", [&] {
      for (const auto& [name, value] : features) yaml.add(name, value);
    });
}

void write_run(const ServoRequest& request, const ServoRun& run, const ServoFigures& figures,
               const std::filesystem::path& targets) {
  if (!run.has_new_results() && std::filesystem::exists(request.folder.path / "run.yaml")) return;
  write_file(request.folder.path / "run.yaml", run_text(request, run, figures, targets));
  std::optional<Refusal> end;
  if (run.ended_by()) end = early_end(*run.ended_by(), run.work_has_moved());
  write_file(request.folder.path / "report.html",
             servo_page(request.cell->settings.file, figures, run.results(), end));
}

ServoFigures conclude_run(const ServoRequest& request, const ServoRun& run,
                          const FrameCounts& frames, const std::filesystem::path& targets) {
  log_failures(run);
  ServoFigures figures = figures_of(run.results());
  figures.frames = frames;
  write_run(request, run, figures, targets);
  return figures;
}

std::string servo_page(const std::filesystem::path& cell_file, const ServoFigures& figures,
                       const std::vector<TargetResult>& results,
                       const std::optional<Refusal>& end) {
  HtmlPage page("Positioning with " + cell_file.filename().string());
  page.add_verdict(servo_verdict(figures, end));
  add_error_plots(page, figures, results);
  page.add_heading("Other figures");
  page.add_paragraph(other_list(figures).text());
  page.add_heading("Targets");
  page.add_paragraph(
      "After own view: the distance by vision itself, whose standard uncertainty per axis is "
      "stated beside it." +
      std::string(figures.is_judged() ? " Last distance: by the " + figures.judge() + "." : ""));
  page.add_html("<div class=\"words\">\n" + target_table(figures, results) + "</div>\n");
  return page.text();
}

}  // namespace planar
