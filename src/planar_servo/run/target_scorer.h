#pragma once

#include <functional>
#include <optional>

#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/run/end_point_judge.h"
#include "planar_servo/servo/position_servo.h"

namespace planar {

/// Follows the steps towards one target over all attempts: logs them, counts corrections, and keeps
/// the first and the last error.
class TargetScorer {
 public:
  /// Takes `true_tip` as CellDevices returns it; it may be empty. The table of steps must outlive
  /// the scorer.
  TargetScorer(const TargetRow& target, GrowingFile& steps, std::function<TipPose()> true_tip);

  /// Takes somebody who judges the end point where there is no truth: at the first look and once
  /// the servo has ended. It may be empty.
  void set_judge(EndPointJudge judge) { judge_ = std::move(judge); }

  /// Takes a step: logs it and updates the outcome. The arm rests meanwhile.
  void observe(const ServoStep& step);

  /// Returns the outcome: how the last attempt ended, with the corrections and the seconds of all
  /// attempts. The arm still rests where it ended.
  TargetResult finish(const ServoResult& last_attempt, double seconds);

 private:
  void compare_to_truth(const ServoStep& step);
  JudgedTip judged() const;
  void judge_end(ServoStatus status);

  GrowingFile& steps_;
  std::function<TipPose()> true_tip_;
  EndPointJudge judge_;
  TargetResult result_;
  std::optional<ServoStep> look_;      ///< the last one; not every look measures the tool
  std::optional<JudgedTip> standing_;  ///< judged where the last look was
};

}  // namespace planar
