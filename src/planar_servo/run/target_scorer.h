#pragma once

#include <optional>

#include "planar_servo/core/clock.h"
#include "planar_servo/devices/judge.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/servo/position_servo.h"
#include "planar_servo/tables/result_table.h"
#include "planar_servo/tables/target_table.h"

namespace planar {

/// Follows the steps towards one target over all attempts: logs them, counts corrections, and keeps
/// the first and the last error.
class TargetScorer {
 public:
  /// Takes who judges the end point, if anybody does: the truth at every look, a tracker at the
  /// first look and once the servo has ended. All three must outlive the scorer.
  TargetScorer(const TargetRow& target, GrowingFile& steps, Judge* judge, const Clock& clock);

  /// Takes a step: logs it and updates the outcome. The arm rests meanwhile.
  void observe(const ServoStep& step);

  /// Returns the outcome: how the last attempt ended, with the corrections and the seconds of all
  /// attempts, less those of judging. The arm still rests where it ended.
  TargetResult finish(const ServoResult& last_attempt, double seconds);

 private:
  bool judges_every_look() const;
  JudgedTip judgement();
  void take_judgement();

  GrowingFile& steps_;
  Judge* judge_;
  const Clock& clock_;
  double judging_s_{0.0};
  TargetResult result_;
  std::optional<ServoStep> look_;    ///< the last one; not every look measures the tool
  std::optional<JudgedTip> judged_;  ///< where the last look was, once it was judged
};

}  // namespace planar
