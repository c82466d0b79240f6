#include "planar_servo/run/servo_run.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/files/tables/step_table.h"
#include "planar_servo/offline/record/motion_plan.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr double kCameraPatience_s = 60.0;  ///< for a camera that fails, from a target's beginning
constexpr double kCameraPoll_s = 0.05;
constexpr double kDrivePatience_s = 60.0;
constexpr int kMaxDriveRecoveries =
    3;  ///< of one target; a drive that fails again and again is broken

std::vector<TargetResult> results_so_far(const fs::path& folder, bool resume) {
  const fs::path results = folder / "results.csv";
  const bool begun = fs::exists(results);
  if (begun && !resume)
    throw InputError(results.string() +
                     ": holds a run already; name another folder or add --resume");
  if (!begun && resume)
    throw InputError(folder.string() +
                     ": holds no run to go on with; name the folder of one, or leave out --resume "
                     "to begin one there");
  return begun ? read_results(results) : std::vector<TargetResult>();
}

const fs::path& folder_made(const fs::path& path) {
  make_folder(path);
  return path;
}

TipPose target_pose(const TargetRow& target, double tool_orientation) {
  return {target.p_d, target.phi_d.value_or(tool_orientation)};
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
    if (step.iteration > 0 || result_.before_own) return;
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

ServoRun::ServoRun(const ServoRequest& request, CellDevices& devices, Observer observer)
    : cell_(request.cell),
      camera_(devices.camera()),
      clock_(devices.clock()),
      observer_(std::move(observer)),
      may_home_(request.may_home),
      true_tip_(devices.true_tip()),
      results_(results_so_far(request.out, request.resume)),
      sensor_(cell_, read_vision(cell_, request.use_error_map), request.center, devices.camera()),
      steps_(folder_made(request.out) / "steps.csv", steps_header()),
      table_(request.out / "results.csv", results_header()),
      robot_(PlanarArm(cell_.arm.geometry), Transmission(cell_.transmission), devices.drives(),
             devices.clock()),
      servo_(cell_.servo, joint_planner(cell_), robot_, sensor_, devices.clock()) {
  robot_.stop_when(request.stop);
  robot_.energize();
  sensor_.aim(robot_.arm().forward(robot_.commanded_joints()));
}

const TargetResult& ServoRun::move_to(const TargetRow& target) {
  TargetScorer scorer(target, steps_, true_tip_);
  const auto attempt = [&] {
    return servo_.move_to(target_pose(target, cell_.tool_orientation), [&](const ServoStep& step) {
      scorer.observe(step);
      if (!observer_) return;
      const TipPose& wanted = step.target;
      observer_({target.id, step, sensor_.last_frame(),
                 sensor_.lamps_at({wanted.p + step.measurement.correction, wanted.phi})});
    });
  };
  const double deadline_s = clock_.now_s() + kCameraPatience_s;
  ServoResult outcome = with_drives(target.id, attempt);
  while (outcome.status == ServoStatus::kLostCamera &&
         wait_for_camera(target.id, outcome.reason, deadline_s))
    outcome = with_drives(target.id, attempt);
  results_.push_back(scorer.finish(outcome));
  table_.append(result_line(results_.back()));
  return results_.back();
}

ServoResult ServoRun::with_drives(const std::string& id,
                                  const std::function<ServoResult()>& attempt) {
  for (int recoveries = 0;; ++recoveries) {
    try {
      return attempt();
    } catch (const DriveError& error) {
      if (recoveries == kMaxDriveRecoveries) throw;
      recover_drives(id, error.what());
    }
  }
}

void ServoRun::recover_drives(const std::string& id, const std::string& reason) {
  spdlog::warn("{}: {}; the arm stands and waits", id, reason);
  robot_.recover(kDrivePatience_s);
  const std::vector<int> unhomed = robot_.unhomed();
  if (!unhomed.empty()) {
    std::string text = "drives that have lost their position:";
    for (const int joint : unhomed) text += fmt::format(" {}", joint + 1);
    if (!may_home_ || !may_home_(text))
      throw DriveError(text + "; home them with planar-jog, then go on with --resume");
    for (const int joint : unhomed) robot_.search_home(joint);
  }
  spdlog::info("{}: the drives are ready again; going on", id);
}

bool ServoRun::wait_for_camera(const std::string& id, const std::string& reason,
                               double deadline_s) {
  const double lost_s = clock_.now_s();
  spdlog::warn("{}: {}; the arm stands and waits", id, reason);
  while (camera_.fault()) {
    if (clock_.now_s() > deadline_s) return false;
    robot_.throw_if_stopped();
    clock_.sleep_for_s(kCameraPoll_s);
  }
  if (clock_.now_s() > deadline_s) return false;
  spdlog::info("{}: the camera delivers again after {:.1f} s; going on", id,
               clock_.now_s() - lost_s);
  return true;
}

bool ServoRun::has(const std::string& id) const {
  return std::any_of(results_.begin(), results_.end(),
                     [&](const TargetResult& result) { return result.id == id; });
}

std::vector<TargetResult> run_servo(
    ServoRun& run, const std::vector<TargetRow>& targets,
    const std::function<void(std::size_t done, std::size_t all)>& progress) {
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (run.has(targets[i].id)) continue;
    run.move_to(targets[i]);
    if (progress) progress(i + 1, targets.size());
  }
  return run.results();
}

DryRun::DryRun(const CellSettings& cell)
    : tool_orientation_(cell.tool_orientation),
      planner_(joint_planner(cell)),
      near_(cell.arm.home) {}

DryRunRow DryRun::plan(const TargetRow& target) {
  DryRunRow row{target.id, planner_.plan(target_pose(target, tool_orientation_), near_),
                Pulses::Zero()};
  if (row.plan.refusal) return row;
  near_ = row.plan.theta;
  row.pulses = planner_.transmission().pulses_from_joints(near_);
  return row;
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
