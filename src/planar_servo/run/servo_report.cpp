#include "planar_servo/run/servo_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/yaml_writer.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/text_table.h"

namespace planar {
namespace {

double mm(double metres) {
  return metres / kMillimetre;
}

double improvement(const Summary& before, const Summary& after) {
  return 1.0 - after.mean / before.mean;
}

void add_figures(nlohmann::json& json, const std::string& suffix,
                 const std::optional<Summary>& before, const std::optional<Summary>& after) {
  if (!before || !after) return;
  json["before_mean_mm" + suffix] = mm(before->mean);
  json["after_mean_mm" + suffix] = mm(after->mean);
  json["after_rms_mm" + suffix] = mm(after->rms);
  json["after_p95_mm" + suffix] = mm(after->p95);
  json["after_max_mm" + suffix] = mm(after->max);
  json["improvement" + suffix] = improvement(*before, *after);
}

std::string figures_line(const char* judge, const std::optional<Summary>& before,
                         const std::optional<Summary>& after) {
  if (!before || !after) return "";
  return fmt::format(
      "{}: the arm alone {:.4f} mm mean; with vision {:.4f} mm mean, {:.4f} rms, {:.4f} at 95 %, "
      "{:.4f} max\n",
      judge, mm(before->mean), mm(after->mean), mm(after->rms), mm(after->p95), mm(after->max));
}

void add_tracker(nlohmann::json& json, const TrackerFigures& tracker) {
  json["judged"] = tracker.judged;
  json["not_judged"] = nlohmann::json::array();
  for (const auto& [target, reason] : tracker.not_judged)
    json["not_judged"].push_back({{"target", target}, {"reason", reason}});
  if (tracker.judged == 0) return;
  json["sigma_mm_truth"] = mm(tracker.sigma);
  json["after_rms_net_mm_truth"] = mm(tracker.after_net);
}

std::string tracker_text(const TrackerFigures& tracker) {
  std::string text;
  if (tracker.judged > 0)
    text = fmt::format(
        "the tracker's word is known to {:.4f} mm per axis; with that taken out: after {:.4f} "
        "rms\n",
        mm(tracker.sigma), mm(tracker.after_net));
  for (const auto& [target, reason] : tracker.not_judged)
    text += fmt::format("not judged: {}: {}\n", target, reason);
  return text;
}

constexpr char kMadeWorse[] = "vision made the arm worse than it lands alone";

const char* judge_of(const ServoFigures& figures) {
  return figures.tracker ? "against the tracker" : "against the truth";
}

std::string coverage_words(const ServoFigures& figures) {
  constexpr double kLeast = 0.90, kMost = 0.98;
  if (!figures.coverage_95) return "";
  const double share = *figures.coverage_95;
  if (share >= kLeast && share <= kMost) return "";
  return fmt::format("; the stated 95 % intervals hold {:.1f} % of the components: they are too {}",
                     100.0 * share, share < kLeast ? "narrow" : "wide");
}

std::string in_mm(const std::optional<Eigen::Vector2d>& error) {
  return error ? fmt::format("{:.4f}", mm(error->norm())) : "–";
}

}  // namespace

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

nlohmann::json servo_json(const ServoFigures& figures) {
  nlohmann::json json{{"targets", figures.targets},
                      {"reached", figures.reached},
                      {"iterations_median", figures.iterations_median},
                      {"seconds_per_target", figures.seconds_per_target}};
  add_figures(json, "_own_view", figures.before_own, figures.after_own);
  add_figures(json, "_truth", figures.before_truth, figures.after_truth);
  if (figures.tracker) add_tracker(json, *figures.tracker);
  if (figures.coverage_95) json["coverage_95_truth"] = *figures.coverage_95;
  if (figures.frames) {
    json["frames_complete"] = figures.frames->complete;
    json["frames_incomplete"] = figures.frames->incomplete;
    json["frames_frozen"] = figures.frames->frozen;
    json["camera_reopened"] = figures.frames->reopened;
  }
  return json;
}

std::string servo_text(const ServoFigures& figures) {
  return fmt::format("{} of {} targets reached, {:g} correction{} and {:.2f} s each\n",
                     figures.reached, figures.targets, figures.iterations_median,
                     figures.iterations_median == 1.0 ? "" : "s", figures.seconds_per_target) +
         figures_line(judge_of(figures), figures.before_truth, figures.after_truth) +
         (figures.made_worse ? std::string(kMadeWorse) + "\n" : "") +
         (figures.tracker ? tracker_text(*figures.tracker) : "") +
         figures_line("by its own view", figures.before_own, figures.after_own) +
         (figures.coverage_95
              ? fmt::format(
                    "vision: {:.1f} % of the components within their stated 95 % interval\n",
                    100.0 * *figures.coverage_95)
              : "") +
         (figures.frames ? "camera: " + describe(*figures.frames) + "\n" : "");
}

std::string landing_words(const ServoFigures& figures) {
  const bool is_judged = figures.before_truth && figures.after_truth;
  const auto& before = is_judged ? figures.before_truth : figures.before_own;
  const auto& after = is_judged ? figures.after_truth : figures.after_own;
  if (!before || !after) return "";
  return fmt::format(
      "{} the arm alone lands {:.4f} mm from its targets in the mean, with vision "
      "{:.4f} mm{}",
      is_judged ? judge_of(figures) : "by its own view", mm(before->mean), mm(after->mean),
      coverage_words(figures));
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
  page.add_paragraph(servo_text(figures));
  const bool truth = !results.empty() && results.front().before_truth.has_value();
  const QuiverPanel before = error_panel(
      "The arm alone", results, truth ? &TargetResult::before_truth : &TargetResult::before_own);
  const QuiverPanel after = error_panel(
      "With vision", results, truth ? &TargetResult::after_truth : &TargetResult::after_own);
  page.add_heading(truth ? "Errors against the truth" : "Errors by the servo's own view");
  if (!before.points.empty()) {
    page.add_html(quiver_svg({before, after}));
    page.add_paragraph(kQuiverCaption);
    page.add_html(quiver_svg({after}));
    page.add_paragraph("The last panel once more, at scales of its own.");
  }
  TextTable table("Targets", {"target", "x mm", "y mm", "status", "corrections", "own view mm",
                              "uncertainty mm", "truth mm"});
  for (const TargetResult& r : results)
    table.add_row({r.id, fixed(mm(r.p_d.x()), 3), fixed(mm(r.p_d.y()), 3),
                   r.reason.empty() ? name(r.status) : name(r.status) + (": " + r.reason),
                   std::to_string(r.iterations), in_mm(r.after_own),
                   r.uncertainty_m ? fmt::format("{:.4f}", mm(*r.uncertainty_m)) : "–",
                   in_mm(r.after_truth)});
  page.add_html(table.html());
  return page.text();
}

namespace {

/// Returns the text of run.yaml: the files used with their hashes, settings and outcome.
std::string run_text(const ServoRequest& request, const ServoRun& run, const ServoFigures& figures,
                     const std::vector<std::filesystem::path>& inputs) {
  YamlWriter yaml = YamlWriter::with_header("run", "planar-servo");
  yaml.add_inputs(input_records(inputs));
  yaml.add("error_map_used", request.use_error_map);
  if (!run.accepted_stale().empty()) yaml.add("accepted_stale", run.accepted_stale());
  if (run.accepted_map()) yaml.add("accepted_map", *run.accepted_map());
  yaml.add("targets", static_cast<int>(figures.targets));
  yaml.add("reached", static_cast<int>(figures.reached));
  if (figures.frames) yaml.add("camera", describe(*figures.frames));
  yaml.begin_map("figures");
  const nlohmann::json figures_json = servo_json(figures);
  for (const auto& [key, value] : figures_json.items())
    if (value.is_number_float()) yaml.add(key, value.get<double>());
  yaml.end_map();
  return yaml.text();
}

}  // namespace

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
