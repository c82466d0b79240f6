#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/health/cause.h"
#include "planar_servo/health/health_record.h"
#include "planar_servo/io/folder_lock.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/robot/planar_robot.h"
#include "planar_servo/servo/position_servo.h"
#include "planar_servo/vision/lamp_tip_sensor.h"

namespace planar {

/// Says how a cell closes its loop, and where the run's files go.
struct ServoRequest {
  CellSettings cell;
  CenterMethod center{CenterMethod::kAuto};  ///< the way in which lamps' centres are measured
  bool use_error_map{true};
  std::filesystem::path out;  ///< steps.csv and results.csv grow here, a line at a time
  bool resume{false};         ///< continues the run that the folder holds
  bool accept_stale{false};   ///< moves even with files that do not belong together
  bool check_health{true};    ///< looks, before the first target, whether the cell is as it was
  bool keep_going{false};     ///< tries the next target even when the cell itself is in doubt
  /// Is asked whether drives that lost their position may be homed now, which moves the arm. Its
  /// argument names the drives in words. Empty: they may not.
  std::function<bool(const std::string& unhomed)> may_home{};
  std::function<bool()> stop{};  ///< asked during every move; see PlanarRobot::stop_when()
};

/// Returns the sentences on calibration files that do not belong together, and shows them in the
/// log. Throws InputError with them unless they are accepted.
std::vector<std::string> accept_stale_files(const CellSettings& cell, bool with_error_map,
                                            bool accepted);

/// Shows an observer one look of the servo at the tool.
struct ServoSight {
  const std::string& target_id;
  const ServoStep& step;
  const Frame& frame;  ///< the last frame of the measurement
  /// Where the lamps would be with the end point at the target, shifted by the vision error there.
  std::optional<LampPixels> wanted_px;
};

/// Closes a cell's loop over one target after the other: an open-loop move, then corrections by
/// vision. It logs every step.
class ServoRun {
 public:
  /// Is called at every step. It must not take long.
  using Observer = std::function<void(const ServoSight&)>;

  /// Switches the drives on. `observer` may be empty. Throws InputError when the folder holds a run
  /// and `resume` is not set, when it holds none, or one begun with other calibration files, and
  /// `resume` is set, when another program writes there, and for calibration files that do not
  /// belong together unless `accept_stale` is set.
  ServoRun(const ServoRequest& request, CellDevices& devices, Observer observer = {});

  /// Looks before the first target, and every ten minutes after it, whether the cell still is as
  /// its files say and as it was at its calibration; throws WorkError with what it finds. Then
  /// moves to a target and returns its result. A target that fails has a result like the others.
  /// When a device fails for good or somebody stops the arm, it throws WorkError; all that was done
  /// is in the files then.
  ///
  /// When the camera fails, the arm stops and waits up to a minute for it, then goes on with the
  /// same target. It does the same for a drive, which may have to be homed then, but at most three
  /// times for one target. The result counts the corrections and the time of all attempts.
  const TargetResult& move_to(const TargetRow& target);

  /// Returns why no further target may be tried: the cell itself is in doubt. Empty with
  /// `keep_going`.
  const std::optional<std::string>& ended_by() const { return ended_by_; }
  /// Returns true when there is a result of this target.
  bool has(const std::string& id) const;
  /// Returns whether move_to() has added a result to those that the folder held.
  bool has_new_results() const { return results_.size() > results_before_; }
  /// Removes the tables of a run without any result, as when no target could be read.
  void discard_if_empty();
  /// Returns the sentences on files that do not belong together and were accepted.
  const std::vector<std::string>& accepted_stale() const { return accepted_stale_; }
  /// Returns the results so far. Those of a resumed run begin with those that the folder holds.
  const std::vector<TargetResult>& results() const { return results_; }

 private:
  bool must_examine() const;
  /// Throws WorkError when the cell is not well, and says so when nothing is known of its health.
  void examine();
  /// Makes one attempt at a target, or a check, and makes it again after a drive that failed is
  /// back, but at most `recoveries_left` times.
  template <typename Attempt>
  auto with_drives(const std::string& id, int& recoveries_left, const Attempt& attempt)
      -> decltype(attempt());
  /// Waits for the drives. Throws DriveError when they are not back in time or may not be homed.
  void recover_drives(const std::string& id, const std::string& reason);
  /// Waits for the camera. Returns false when it is not back in time.
  bool wait_for_camera(const std::string& id, const std::string& reason, double deadline_s);

  CellSettings cell_;
  FrameSource& camera_;
  Clock& clock_;
  Observer observer_;
  std::function<bool(const std::string&)> may_home_;
  std::function<TipPose()> true_tip_;
  bool check_health_, keep_going_;
  std::optional<double> examined_s_;  ///< when the cell was last looked at
  std::optional<std::string> ended_by_;
  VisionCalibration vision_;
  std::optional<HealthRecord> health_;
  LampTipSensor sensor_;
  std::vector<std::string> accepted_stale_;
  FolderLock lock_;
  std::vector<TargetResult> results_;
  std::size_t results_before_;
  GrowingFile steps_;
  GrowingFile table_;
  PlanarRobot robot_;
  PositionServo servo_;
};

/// Moves to every target in turn, except those that a resumed run has a result of, until the run is
/// ended_by() one. `progress` may be empty. Throws InputError, before anything moves, when such a
/// result is of another place.
std::vector<TargetResult> run_servo(
    ServoRun& run, const std::vector<TargetRow>& targets,
    const std::function<void(std::size_t done, std::size_t all)>& progress = {});

}  // namespace planar
