#include "app/servo_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

#include "app/motion_plan.h"
#include "core/units.h"
#include "text/csv_table.h"
#include "text/growing_file.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

std::string steps_header() {
  return CsvWriter("steps",
                   {"target",         "step",       "t_s",        "status",      "u1_px",
                    "v1_px",          "u2_px",      "v2_px",      "x_vision_mm", "y_vision_mm",
                    "phi_deg",        "dx_map_mm",  "dy_map_mm",  "x_mm",        "y_mm",
                    "uncertainty_mm", "dx_mm",      "dy_mm",      "error_mm",    "stop_below_mm",
                    "theta1_deg",     "theta2_deg", "theta3_deg", "m1_pulses",   "m2_pulses",
                    "m3_pulses"})
      .text();
}

std::string in_mm(const Eigen::Vector2d& p) {
  return fmt::format("{:.6f},{:.6f}", p.x() / kMillimetre, p.y() / kMillimetre);
}

std::string step_line(const std::string& id, const ServoStep& step) {
  const TipMeasurement& m = step.measurement;
  std::string seen = ",,,,,,,,,,,,,,";
  if (m.ok())
    seen = fmt::format("{:.4f},{:.4f},{:.4f},{:.4f},{},{:.6f},{},{},{:.6f},{},{:.6f}",
                       m.lamps_px[0].x(), m.lamps_px[0].y(), m.lamps_px[1].x(), m.lamps_px[1].y(),
                       in_mm(m.p_vision), m.tip.phi / kDegree, in_mm(m.correction), in_mm(m.tip.p),
                       m.uncertainty_m / kMillimetre, in_mm(step.error),
                       step.error.norm() / kMillimetre);
  const Joints deg = step.theta_c / kDegree;
  return fmt::format("{},{},{:.6f},{},{},{:.6f},{:.9f},{:.9f},{:.9f},{},{},{}\n", id,
                     step.iteration, m.t_s, m.status, seen, step.stop_below_m / kMillimetre, deg[0],
                     deg[1], deg[2], step.pulses_c[0], step.pulses_c[1], step.pulses_c[2]);
}

std::string results_header() {
  return CsvWriter("results", {"target", "x_mm", "y_mm", "status", "reason", "iterations",
                               "seconds", "before_own_view_mm", "after_own_view_mm",
                               "uncertainty_mm", "before_truth_mm", "after_truth_mm"})
      .text();
}

std::string length_mm(const std::optional<Eigen::Vector2d>& error) {
  return error ? fmt::format("{:.6f}", error->norm() / kMillimetre) : "";
}

std::string result_line(const TargetResult& result) {
  std::string reason = result.reason;
  std::replace(reason.begin(), reason.end(), ',', ';');
  return fmt::format("{},{},{},{},{},{:.3f},{},{},{:.6f},{},{}\n", result.id, in_mm(result.p_d),
                     name(result.status), reason, result.iterations, result.seconds,
                     length_mm(result.before_own), length_mm(result.after_own),
                     result.uncertainty_m / kMillimetre, length_mm(result.before_truth),
                     length_mm(result.after_truth));
}

std::set<std::string> finished_targets(const fs::path& results, bool resume) {
  std::set<std::string> ids;
  if (!fs::exists(results)) return ids;
  if (!resume)
    throw InputError(results.string() +
                     ": holds a run already; name another folder or add --resume");
  const CsvTable table = CsvTable::read(results, "results", {"target"});
  for (std::size_t row = 0; row < table.size(); ++row) ids.insert(table.text(row, "target"));
  return ids;
}

TipPose target_pose(const CellSettings& cell, const TargetRow& target) {
  return {target.p_d, target.phi_d.value_or(cell.tool_orientation)};
}

/// Follows one target's steps: logs them and keeps the first and last error.
class TargetScorer {
 public:
  TargetScorer(const TargetRow& target, GrowingFile& steps, std::function<TipPose()> true_tip)
      : steps_(steps), true_tip_(std::move(true_tip)) {
    result_.id = target.id;
    result_.p_d = target.p_d;
  }

  void observe(const ServoStep& step) {
    steps_.append(step_line(result_.id, step));
    if (step.measurement.ok()) {
      result_.after_own = -step.error;
      result_.uncertainty_m = step.measurement.uncertainty_m;
    }
    if (true_tip_) compare_to_truth(step.measurement);
    if (step.iteration > 0) return;
    result_.before_own = result_.after_own;
    result_.before_truth = result_.after_truth;
  }

  TargetResult finish(const ServoResult& servo) {
    result_.status = servo.status;
    result_.reason = servo.reason;
    result_.iterations = servo.iterations;
    result_.seconds = servo.duration_s;
    return result_;
  }

 private:
  void compare_to_truth(const TipMeasurement& measurement) {
    const Eigen::Vector2d p_truth = true_tip_().p;
    result_.after_truth = p_truth - result_.p_d;
    if (!measurement.ok()) return;
    result_.vision_raw = measurement.p_vision - p_truth;
    result_.vision_compensated = measurement.tip.p - p_truth;
  }

  GrowingFile& steps_;
  std::function<TipPose()> true_tip_;
  TargetResult result_;
};

std::optional<Summary> summary_of(const std::vector<TargetResult>& results, TargetError error) {
  const std::vector<double> lengths = error_lengths(results, error);
  if (lengths.empty()) return std::nullopt;
  return summarize(lengths);
}

}  // namespace

std::vector<TargetResult> run_servo(const ServoRequest& request, CellDevices& devices) {
  const CellSettings& cell = request.cell;
  const std::set<std::string> finished =
      finished_targets(request.out / "results.csv", request.resume);
  LampTipSensor sensor(cell, read_vision(cell, request.use_error_map), request.center,
                       devices.camera());
  make_folder(request.out);
  GrowingFile steps(request.out / "steps.csv", steps_header());
  GrowingFile table(request.out / "results.csv", results_header());
  const JointPlanner planner = joint_planner(cell);
  PlanarRobot robot(planner.arm(), planner.transmission(), devices.drives(), devices.clock());
  robot.energize();
  PositionServo servo(cell.servo, planner, robot, sensor, devices.clock());
  std::vector<TargetResult> results;
  for (std::size_t i = 0; i < request.targets.size(); ++i) {
    const TargetRow& target = request.targets[i];
    if (finished.count(target.id) != 0) continue;
    TargetScorer scorer(target, steps, devices.true_tip());
    const ServoResult outcome = servo.move_to(target_pose(cell, target),
                                              [&](const ServoStep& step) { scorer.observe(step); });
    results.push_back(scorer.finish(outcome));
    table.append(result_line(results.back()));
    if (request.progress) request.progress(i + 1, request.targets.size());
  }
  return results;
}

std::vector<DryRunRow> dry_run(const CellSettings& cell, const std::vector<TargetRow>& targets) {
  const JointPlanner planner = joint_planner(cell);
  std::vector<DryRunRow> rows;
  Joints near = cell.arm.home;
  for (const TargetRow& target : targets) {
    DryRunRow row{target.id, planner.plan(target_pose(cell, target), near), Pulses::Zero()};
    if (!row.plan.refusal) {
      near = row.plan.theta;
      row.pulses = planner.transmission().pulses_from_joints(near);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<double> error_lengths(const std::vector<TargetResult>& results, TargetError error,
                                  const std::string& prefix) {
  std::vector<double> lengths;
  for (const TargetResult& result : results)
    if (result.id.rfind(prefix, 0) == 0 && result.*error)
      lengths.push_back((result.*error)->norm());
  return lengths;
}

double mean_error(const std::vector<TargetResult>& results, TargetError error,
                  const std::string& prefix) {
  const std::vector<double> lengths = error_lengths(results, error, prefix);
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
  return figures;
}

}  // namespace planar
