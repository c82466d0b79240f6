#pragma once

#include <functional>

#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/servo/position_servo.h"

namespace planar {

/// Follows the steps towards one target over all attempts: logs them, counts corrections, and keeps
/// the first and the last error.
class TargetScorer {
 public:
  /// Takes `true_tip` as CellDevices returns it; it may be empty. The table of steps must outlive
  /// the scorer.
  TargetScorer(const TargetRow& target, GrowingFile& steps, std::function<TipPose()> true_tip);

  /// Takes a step: logs it and updates the outcome.
  void observe(const ServoStep& step);

  /// Returns the outcome: how the last attempt ended, with the corrections and the seconds of all
  /// attempts.
  TargetResult finish(const ServoResult& last_attempt, double seconds);

 private:
  void compare_to_truth(const TipMeasurement& measurement);

  GrowingFile& steps_;
  std::function<TipPose()> true_tip_;
  TargetResult result_;
};

}  // namespace planar
