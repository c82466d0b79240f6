#include "planar_servo/run/target_scorer.h"

#include "planar_servo/tables/step_table.h"

namespace planar {

TargetScorer::TargetScorer(const TargetRow& target, GrowingFile& steps, Judge* judge,
                           const Clock& clock)
    : steps_(steps), judge_(judge), clock_(clock) {
  result_.id = target.id;
  result_.p_d = target.p_d;
}

void TargetScorer::observe(const ServoStep& step) {
  steps_.append(step_line(result_.id, step));
  if (step.measurement.ok()) {
    result_.after_own = -step.error;
    result_.uncertainty_m = step.uncertainty_m();
  }
  const bool is_first = step.iteration == 0 && !result_.before_own;
  look_ = step;
  judged_.reset();
  if (step.iteration > 0) ++result_.iterations;
  if (is_first) result_.before_own = result_.after_own;
  if (!judge_ || !(is_first || judges_every_look())) return;
  judged_ = judgement();
  if (is_first && judged_->p) result_.before_truth = *judged_->p - result_.p_d;
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

bool TargetScorer::judges_every_look() const {
  return judge_->kind() == JudgeKind::kTruth;
}

JudgedTip TargetScorer::judgement() {
  if (!look_) return {{}, 0.0, "the arm did not arrive"};
  const double begun_s = clock_.now_s();
  JudgedTip tip = judge_->judge(result_.id, look_->standing());
  judging_s_ += clock_.now_s() - begun_s;
  return tip;
}

void TargetScorer::take_judgement() {
  result_.not_judged = judged_->fault;
  if (!judged_->p) return;
  const Eigen::Vector2d& p = *judged_->p;
  result_.after_truth = p - result_.p_d;
  if (judge_->kind() == JudgeKind::kTracker) result_.sigma_truth_m = judged_->sigma;
  const TipMeasurement& seen = look_->measurement;
  if (!seen.ok()) return;
  result_.vision_raw = seen.p_vision - p;
  result_.vision_compensated = seen.tip.p - p;
  result_.believed = look_->believed_p() - p;
}

}  // namespace planar
