#include "app/servo_run.h"

#include <algorithm>
#include <limits>

#include "app/motion_plan.h"
#include "core/error.h"
#include "core/units.h"
#include "text/growing_file.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

std::vector<TargetResult> results_so_far(const fs::path& results, bool resume) {
  if (!fs::exists(results)) return {};
  if (!resume)
    throw InputError(results.string() +
                     ": holds a run already; name another folder or add --resume");
  return read_results(results);
}

bool is_among(const std::vector<TargetResult>& results, const std::string& id) {
  return std::any_of(results.begin(), results.end(),
                     [&](const TargetResult& result) { return result.id == id; });
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
  std::vector<TargetResult> results = results_so_far(request.out / "results.csv", request.resume);
  LampTipSensor sensor(cell, read_vision(cell, request.use_error_map), request.center,
                       devices.camera());
  make_folder(request.out);
  GrowingFile steps(request.out / "steps.csv", steps_header());
  GrowingFile table(request.out / "results.csv", results_header());
  const JointPlanner planner = joint_planner(cell);
  PlanarRobot robot(planner.arm(), planner.transmission(), devices.drives(), devices.clock());
  robot.energize();
  PositionServo servo(cell.servo, planner, robot, sensor, devices.clock());
  for (std::size_t i = 0; i < request.targets.size(); ++i) {
    const TargetRow& target = request.targets[i];
    if (is_among(results, target.id)) continue;
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
