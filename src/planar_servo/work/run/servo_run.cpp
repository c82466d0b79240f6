#include "planar_servo/work/run/servo_run.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/work/run/dry_run.h"

namespace planar {

TargetScorer::TargetScorer(const TargetRow& target, GrowingFile* steps, Judge* judge,
                           const Clock& clock)
    : steps_(steps), judge_(judge), clock_(clock) {
  result_.id = target.id;
  result_.p_d = target.p_d;
  result_.sigma_target_m = target.sigma_m;
  p_TE_ = target.p_TE;
}

void TargetScorer::observe(const ServoStep& step) {
  if (steps_ != nullptr) steps_->append(step_line(result_.id, step));
  if (step.measurement.ok()) {
    result_.after_own = -step.error;
    result_.uncertainty_m = std::hypot(step.uncertainty_m(), result_.sigma_target_m,
                                       p_TE_.norm() * step.measurement.turn_sigma);
  }
  const bool is_first = step.iteration == 0 && !result_.before_own;
  look_ = step;
  judged_.reset();
  if (step.iteration > 0) ++result_.iterations;
  if (is_first) result_.before_own = result_.after_own;
  if (!judge_ || !(is_first || judges_every_look())) return;
  judged_ = judgement();
  if (is_first && judged_->p) result_.before_judged = judged_tip() - result_.p_d;
  if (judges_every_look()) take_judgement();
}

TargetResult TargetScorer::finish(const ServoResult& last_attempt, double seconds) {
  result_.status = last_attempt.status;
  result_.reason = last_attempt.reason;
  if (judge_ && !judges_every_look()) {
    // Only a target that was reached is known to end where the last look was.
    if (!judged_ || result_.status != ServoStatus::kReached) judged_ = judgement();
    take_judgement();
  }
  result_.seconds = seconds - judging_s_;
  return result_;
}

JudgedTip TargetScorer::judgement() {
  if (!look_) return {{}, 0.0, "the arm did not arrive"};
  const double begun_s = clock_.now_s();
  JudgedTip tip = judge_->judge(result_.id, look_->standing());
  judging_s_ += clock_.now_s() - begun_s;
  return tip;
}

Eigen::Vector2d TargetScorer::judged_tip() const {
  const double phi = judged_->phi.value_or(look_->measurement.ok() ? look_->measurement.tip.phi
                                                                   : look_->target.phi);
  return *judged_->p + rotation2d(phi) * p_TE_;
}

void TargetScorer::take_judgement() {
  result_.not_judged = judged_->fault;
  if (!judged_->p) return;
  const Eigen::Vector2d& p = *judged_->p;
  result_.after_judged = judged_tip() - result_.p_d;
  if (judge_->kind() == JudgeKind::kTracker) result_.sigma_judged_m = judged_->sigma;
  const TipMeasurement& seen = look_->measurement;
  if (!seen.ok()) return;
  result_.vision_raw = seen.p_vision - p;
  result_.vision_compensated = seen.tip.p - p;
  result_.believed = look_->believed_p() - p;
}

namespace {

/// Returns whether the camera, once the arm had arrived, gave no picture at all.
bool saw_nothing(const ServoResult& attempt) {
  return !attempt.steps.empty() &&
         attempt.steps.front().measurement.status == TipStatus::kNoPicture;
}

[[noreturn]] void give_up(const TargetRow& target, const std::string& reason,
                          const std::string& camera) {
  throw WorkError({fmt::format("{}; the camera {}", reason, camera),
                   "mend it, then start again to continue", target.id, Cause::kDevice});
}

/// Returns the answer to a target that comes after a run has ended.
TargetResult refused(const TargetRow& target, const std::string& ended_by) {
  TargetResult result;
  result.id = target.id;
  result.p_d = target.p_d;
  result.reason = "the run has ended at " + ended_by;
  return result;
}

}  // namespace

ServoRun::ServoRun(const ServoRequest& request, CellDevices& devices, Observer observer)
    : observer_(std::move(observer)),
      judge_(devices.truth() ? devices.truth() : request.judge),
      keep_going_(request.accepted.doubts),
      cell_(request, devices),
      works_(request.works, *request.cell->vision, devices.camera(), devices.clock()),
      files_(request.folder.path.empty() ? std::nullopt : std::make_optional<RunFiles>(request)),
      results_(files_ ? files_->begun : std::vector<TargetResult>()),
      results_before_(results_.size()),
      well_until_(results_before_) {
  cell_.switch_on();
}

ServoRun::~ServoRun() {
  if (files_ && (!results_.empty() || cell_.has_moved_on())) files_->folder.keep();
}

ServoResult ServoRun::attempt(const TargetRow& target, TargetScorer& scorer) {
  const TipPose pose = end_point_pose(target, cell_.settings().tool_orientation);
  const auto observer = [&](const ServoStep& step) {
    scorer.observe(step);
    spdlog::debug(fmt::format("{}, step {}: {:.4f} mm from the target, content below {:.4f} mm",
                              target.id, step.iteration, mm(step.miss_m()), mm(step.stop_below_m)));
    if (!observer_) return;
    const TipPose& wanted = step.target;
    const LampTipSensor& sensor = cell_.sensor();
    observer_({target.id, step, sensor.last_frame(),
               sensor.lamps_at({wanted.p + step.measurement.correction, wanted.phi})});
  };
  return cell_.servo().move_to(pose, observer, target.p_TE);
}

ServoResult ServoRun::attempts(const TargetRow& target, TargetScorer& scorer) {
  int recoveries_left = ReadyCell::kMaxDriveRecoveries;
  int failures = 0;
  double deadline_s = 0.0;
  while (true) {
    const int recoveries_before = recoveries_left;
    ServoResult outcome =
        cell_.with_drives(target.id, recoveries_left, [&] { return attempt(target, scorer); });
    if (outcome.status != ServoStatus::kLostCamera) return outcome;
    // Patience is renewed once the camera was back, and after a wait for drives.
    if (failures == 0 || recoveries_left != recoveries_before || !saw_nothing(outcome)) {
      ++failures;
      deadline_s = cell_.clock().now_s() + kCameraPatience_s;
    }
    if (failures > ReadyCell::kMaxCameraFailures)
      give_up(target, outcome.reason, fmt::format("has failed {} times at this target", failures));
    if (!cell_.wait_for_camera(target.id, outcome.reason, deadline_s))
      give_up(target, outcome.reason,
              fmt::format("was not back within {:.0f} s", kCameraPatience_s));
  }
}

void ServoRun::take_finding(const std::optional<std::string>& unwell) {
  if (!unwell) return;
  if (!unwell->empty()) {
    doubt_what_was_reached();
    if (!keep_going_) ended_by_ = "a look at the cell: " + *unwell;
  }
  well_until_ = results_.size();
}

void ServoRun::doubt_what_was_reached() {
  for (std::size_t i = well_until_; i < results_.size(); ++i) {
    if (results_[i].status != ServoStatus::kReached) continue;
    results_[i].status = ServoStatus::kDoubted;
    results_[i].reason = "was reached before the cell was found not to be well";
  }
  if (files_) write_results(files_->table_file, files_->table_header, results_);
}

std::optional<std::string> ServoRun::finding(bool at_end) {
  std::optional<std::string> unwell = at_end ? cell_.examine_at_end() : cell_.examine_if_due();
  if (unwell && !unwell->empty()) return unwell;
  if (!at_end && !unwell && !works_.is_due()) return std::nullopt;
  std::string moved = works_.examine([this] { return cell_.stand_aside(); });
  work_has_moved_ = !moved.empty();
  if (moved.empty()) {
    work_well_until_ = results_.size();
    return unwell;
  }
  well_until_ = std::max(well_until_, work_well_until_);
  return moved;
}

void ServoRun::finish() {
  if (!ended_by_) take_finding(finding(true));
}

TargetResult ServoRun::move_to(const TargetRow& target) {
  if (!ended_by_) take_finding(finding(false));
  if (ended_by_) return refused(target, *ended_by_);
  TargetScorer scorer(target, files_ ? &files_->steps : nullptr, judge_.get(), cell_.clock());
  const double start_s = cell_.clock().now_s();
  const ServoResult outcome = attempts(target, scorer);
  results_.push_back(scorer.finish(outcome, cell_.clock().now_s() - start_s));
  results_.back().phi_d = target_pose(target, cell_.settings().tool_orientation).phi;
  if (files_) files_->table.append(result_line(results_.back()), Durability::kPowerLoss);
  if (outcome.cell_in_doubt && !keep_going_) {
    ended_by_ = fmt::format("{}: {}: {}", target.id, name(outcome.status), outcome.reason);
    doubt_what_was_reached();
  }
  cell_.keep_lessons_if_due();
  return results_.back();
}

void ServoRun::require_same(const TargetRow& target) const {
  require_same_goal(target.id, target_pose(target, cell_.settings().tool_orientation), results_);
}

bool ServoRun::has(const std::string& id) const {
  return std::any_of(results_.begin(), results_.end(),
                     [&](const TargetResult& result) { return result.id == id; });
}

std::vector<TargetResult> run_servo(
    ServoRun& run, const std::vector<TargetRow>& targets,
    const std::function<void(std::size_t done, std::size_t all)>& progress) {
  for (const TargetRow& target : targets) run.require_same(target);
  for (std::size_t i = 0; i < targets.size() && !run.ended_by(); ++i) {
    if (run.has(targets[i].id)) continue;
    run.move_to(targets[i]);
    if (progress && run.has(targets[i].id)) progress(i + 1, targets.size());
  }
  run.finish();
  return run.results();
}

}  // namespace planar
