#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/loop/servo/position_servo.h"
#include "planar_servo/work/run/ready_cell.h"
#include "planar_servo/work/run/run_files.h"
#include "planar_servo/work/workpiece/work_watch.h"

namespace planar {

/// Follows the steps towards one target over all attempts: logs them, counts corrections, and keeps
/// the first and the last error.
class TargetScorer {
 public:
  /// Takes the judge of the end point, if any: the truth at every look, a tracker at the first look
  /// and once the servo has ended. All three must outlive the scorer.
  TargetScorer(const TargetRow& target, GrowingFile* steps, Judge* judge, const Clock& clock);

  /// Takes a step: logs it, where there is a file for it, and updates the outcome. The arm rests
  /// meanwhile.
  void observe(const ServoStep& step);

  /// Returns the outcome: how the last attempt ended, with the corrections and the seconds of all
  /// attempts, less those of judging. The arm still rests where it ended.
  TargetResult finish(const ServoResult& last_attempt, double seconds);

 private:
  bool judges_every_look() const { return judge_->kind() == JudgeKind::kTruth; }
  JudgedTip judgement();
  void take_judgement();
  /// Returns where the judge sees the tip of the target's tool.
  Eigen::Vector2d judged_tip() const;

  GrowingFile* steps_;
  Judge* judge_;
  const Clock& clock_;
  double judging_s_{0.0};
  TargetResult result_;
  Eigen::Vector2d p_TE_{0.0, 0.0};
  std::optional<ServoStep> look_;    ///< the last one; not every look measures the tool
  std::optional<JudgedTip> judged_;  ///< where the last look was, once it was judged
};

/// Shows an observer one look of the servo at the tool.
struct ServoSight {
  const std::string& target_id;
  const ServoStep& step;
  const Frame& frame;  ///< the last frame of the measurement
  /// Where the lamps would be with the end point at the target, shifted by the vision error there.
  std::optional<LampPixels> wanted_px;
};

/// Closes a cell's loop over one target after the other: an open-loop move, then corrections by
/// vision. It logs every step, where its request names a folder.
class ServoRun {
 public:
  /// Is called at every step. It must not take long.
  using Observer = std::function<void(const ServoSight&)>;

  /// Switches the drives on. `observer` may be empty. Throws as ReadyCell and RunFiles do.
  ServoRun(const ServoRequest& request, CellDevices& devices, Observer observer = {});
  /// When an exception ends the run before the arm was moved to a target, removes what the run has
  /// made: its tables, and the folder where it was not there.
  ~ServoRun();

  /// Does ReadyCell::examine_if_due() first. Findings after the first check end the run and make
  /// all targets doubted that were reached since the cell was well; `target` is refused then and
  /// has no row. Else moves to the target and returns its result. A target that fails has a result
  /// like the others. Throws WorkError when a device fails for good or somebody stops the arm; all
  /// that was done is in the files then.
  ///
  /// When the camera fails, the arm stops and waits up to a minute for it, then continues with the
  /// same target, but at most twenty times for one target. It does the same for a drive, which may
  /// have to be homed then, but at most three times. The result counts the corrections and the time
  /// of all attempts. A target at which a device has failed for good has no result, so that a
  /// resumed run moves there again.
  TargetResult move_to(const TargetRow& target);
  /// Checks the cell once more when all is done, unless the run was short or the cell is in doubt
  /// already.
  void finish();

  /// Returns why no further target may be tried: the cell itself is in doubt. Empty where doubts
  /// are accepted.
  const std::optional<std::string>& ended_by() const { return ended_by_; }
  /// Returns whether that is because a work has moved: what was reached on it lies elsewhere now.
  bool work_has_moved() const { return work_has_moved_; }
  /// Throws InputError when there is a result of this target, but of another place or direction.
  void require_same(const TargetRow& target) const;
  /// Returns true when there is a result of this target.
  bool has(const std::string& id) const;
  /// Returns whether move_to() has added a result to those that the folder held.
  bool has_new_results() const { return results_.size() > results_before_; }
  const ReadyCell& cell() const { return cell_; }
  /// Returns the results so far. Those of a resumed run begin with those that the folder holds.
  const std::vector<TargetResult>& results() const { return results_; }

 private:
  /// Checks cell and works where that is due. Returns nothing when the cell was not checked, an
  /// empty text when all is well, else what is not.
  std::optional<std::string> finding(bool at_end);
  void take_finding(const std::optional<std::string>& unwell);
  /// Doubts the targets that were reached since the cell was last found well.
  void doubt_what_was_reached();
  ServoResult attempt(const TargetRow& target, TargetScorer& scorer);
  /// Makes attempts until one ends by something else than camera or drives. Throws WorkError when a
  /// device has failed for good.
  ServoResult attempts(const TargetRow& target, TargetScorer& scorer);

  Observer observer_;
  std::shared_ptr<Judge> judge_;  ///< null where nobody judges
  bool keep_going_;
  std::optional<std::string> ended_by_;
  bool work_has_moved_{false};
  ReadyCell cell_;
  WorkWatch works_;
  std::optional<RunFiles> files_;  ///< none where the request names no folder
  std::vector<TargetResult> results_;
  std::size_t results_before_;
  std::size_t well_until_;          ///< number of results when the cell was last found well
  std::size_t work_well_until_{0};  ///< and when the works were
};

/// Moves to every target in turn, except those with a result in a resumed run, until the run is
/// ended_by() one. `progress` may be empty. Throws InputError, before anything moves, when such a
/// result is of another place or direction.
std::vector<TargetResult> run_servo(
    ServoRun& run, const std::vector<TargetRow>& targets,
    const std::function<void(std::size_t done, std::size_t all)>& progress = {});

}  // namespace planar
