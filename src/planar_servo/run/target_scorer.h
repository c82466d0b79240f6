#pragma once

#include <functional>

#include "planar_servo/files/tables/servo_tables.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/servo/position_servo.h"

namespace planar {

/// Follows the steps towards one target, over as many attempts as it takes: logs them, counts
/// corrections, and keeps the first and the last error.
class TargetScorer {
 public:
  /// `true_tip` is as CellDevices has it and may be empty. The table of steps must outlive the
  /// scorer.
  TargetScorer(const TargetRow& target, GrowingFile& steps, std::function<TipPose()> true_tip);

  void observe(const ServoStep& step);

  /// The outcome: how the last attempt ended, with the corrections of all attempts and `seconds` in
  /// all.
  TargetResult finish(const ServoResult& last_attempt, double seconds);

 private:
  void compare_to_truth(const TipMeasurement& measurement);

  GrowingFile& steps_;
  std::function<TipPose()> true_tip_;
  TargetResult result_;
};

}  // namespace planar
