#include "planar_servo/run/target_scorer.h"

#include <utility>

#include "planar_servo/files/tables/step_table.h"

namespace planar {

TargetScorer::TargetScorer(const TargetRow& target, GrowingFile& steps,
                           std::function<TipPose()> true_tip)
    : steps_(steps), true_tip_(std::move(true_tip)) {
  result_.id = target.id;
  result_.p_d = target.p_d;
}

void TargetScorer::observe(const ServoStep& step) {
  steps_.append(step_line(result_.id, step));
  if (step.measurement.ok()) {
    result_.after_own = -step.error;
    result_.uncertainty_m = step.uncertainty_m();
  }
  if (true_tip_) compare_to_truth(step);
  look_ = step;
  standing_.reset();
  if (step.iteration > 0) ++result_.iterations;
  if (step.iteration > 0 || result_.before_own) return;
  result_.before_own = result_.after_own;
  result_.before_truth = result_.after_truth;
  if (!judge_) return;
  standing_ = judged();
  if (standing_->p) result_.before_truth = *standing_->p - result_.p_d;
}

TargetResult TargetScorer::finish(const ServoResult& last_attempt, double seconds) {
  result_.status = last_attempt.status;
  result_.reason = last_attempt.reason;
  result_.seconds = seconds;
  if (judge_) judge_end(last_attempt.status);
  return result_;
}

JudgedTip TargetScorer::judged() const {
  if (!look_) return {{}, 0.0, "the arm did not arrive"};
  return judge_(result_.id, *look_);
}

void TargetScorer::judge_end(ServoStatus status) {
  // Only a target that was reached is known to end where the last look was.
  if (!standing_ || status != ServoStatus::kReached) standing_ = judged();
  result_.not_judged = standing_->fault;
  if (!standing_->p) return;
  result_.after_truth = *standing_->p - result_.p_d;
  result_.sigma_truth_m = standing_->sigma;
  const TipMeasurement& seen = look_->measurement;
  if (!seen.ok()) return;
  result_.vision_raw = seen.p_vision - *standing_->p;
  result_.vision_compensated = seen.tip.p - *standing_->p;
  result_.believed = look_->believed_p() - *standing_->p;
}

void TargetScorer::compare_to_truth(const ServoStep& step) {
  const TipMeasurement& measurement = step.measurement;
  const Eigen::Vector2d p_truth = true_tip_().p;
  result_.after_truth = p_truth - result_.p_d;
  if (!measurement.ok()) return;
  result_.vision_raw = measurement.p_vision - p_truth;
  result_.vision_compensated = measurement.tip.p - p_truth;
  result_.believed = step.believed_p() - p_truth;
}

}  // namespace planar
