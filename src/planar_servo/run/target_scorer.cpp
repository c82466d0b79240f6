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
    result_.uncertainty_m = step.measurement.uncertainty_m;
  }
  if (true_tip_) compare_to_truth(step.measurement);
  if (step.iteration > 0) ++result_.iterations;
  if (step.iteration > 0 || result_.before_own) return;
  result_.before_own = result_.after_own;
  result_.before_truth = result_.after_truth;
}

TargetResult TargetScorer::finish(const ServoResult& last_attempt, double seconds) {
  result_.status = last_attempt.status;
  result_.reason = last_attempt.reason;
  result_.seconds = seconds;
  return result_;
}

void TargetScorer::compare_to_truth(const TipMeasurement& measurement) {
  const Eigen::Vector2d p_truth = true_tip_().p;
  result_.after_truth = p_truth - result_.p_d;
  if (!measurement.ok()) return;
  result_.vision_raw = measurement.p_vision - p_truth;
  result_.vision_compensated = measurement.tip.p - p_truth;
}

}  // namespace planar
