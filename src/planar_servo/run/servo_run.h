#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/core/statistics.h"
#include "planar_servo/files/cell_file.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/robot/planar_robot.h"
#include "planar_servo/servo/position_servo.h"
#include "planar_servo/vision/lamp_tip_sensor.h"

namespace planar {

struct ServoRequest {
  CellSettings cell;
  CenterMethod center{CenterMethod::kAuto};
  bool use_error_map{true};
  std::filesystem::path out;  ///< steps.csv and results.csv grow here, a line at a time
  bool resume{false};         ///< go on with the run that the folder holds
  /// Whether drives that lost their position, named in words, may be homed now, which moves the
  /// arm. Empty: never.
  std::function<bool(const std::string& unhomed)> may_home{};
  std::function<bool()> stop{};  ///< as PlanarRobot::stop_when() has it
};

/// A look of the servo at the tool, for whoever shows it.
struct ServoSight {
  const std::string& target_id;
  const ServoStep& step;
  const Frame& frame;  ///< the last one of the measurement
  /// Where the lamps would be with the end point at the target, as vision errs there.
  std::optional<std::array<Eigen::Vector2d, 2>> wanted_px;
};

/// A cell that closes its loop over one target after the other: an open-loop move, then corrections
/// by vision, every step logged.
class ServoRun {
 public:
  using Observer = std::function<void(const ServoSight&)>;

  /// Switches the drives on. `observer`, which may be empty, is called at every step and must not
  /// take long. Throws InputError when the folder holds a run and `resume` is not set, or none and
  /// it is.
  ServoRun(const ServoRequest& request, CellDevices& devices, Observer observer = {});

  /// A target that fails has a result like the others, unless a device fails or somebody stops the
  /// arm: that throws WorkError, with all that was done in the files. When the camera fails the arm
  /// stops and waits up to a minute for it, then goes on with the same target. So it does for a
  /// drive, which may have to be homed then.
  const TargetResult& move_to(const TargetRow& target);

  bool has(const std::string& id) const;
  /// A resumed run's results begin with those that the folder holds.
  const std::vector<TargetResult>& results() const { return results_; }

 private:
  /// Attempts again after a drive that failed is back.
  ServoResult with_drives(const std::string& id, const std::function<ServoResult()>& attempt);
  /// Throws DriveError when they are not back in time or may not be homed.
  void recover_drives(const std::string& id, const std::string& reason);
  /// False when the camera is not back in time.
  bool wait_for_camera(const std::string& id, const std::string& reason, double deadline_s);

  CellSettings cell_;
  FrameSource& camera_;
  Clock& clock_;
  Observer observer_;
  std::function<bool(const std::string&)> may_home_;
  std::function<TipPose()> true_tip_;
  std::vector<TargetResult> results_;
  LampTipSensor sensor_;
  GrowingFile steps_;
  GrowingFile table_;
  PlanarRobot robot_;
  PositionServo servo_;
};

/// Every target in turn, but for those that a resumed run has a result of. `progress` may be empty.
std::vector<TargetResult> run_servo(
    ServoRun& run, const std::vector<TargetRow>& targets,
    const std::function<void(std::size_t done, std::size_t all)>& progress = {});

/// The joints and pulses that a target's first, open-loop move would command, without any device; a
/// refusal in words where it would not move.
struct DryRunRow {
  std::string id;
  JointPlan plan;
  Pulses pulses{0, 0, 0};
};

/// Plans one target after the other, from the home position on.
class DryRun {
 public:
  explicit DryRun(const CellSettings& cell);
  DryRunRow plan(const TargetRow& target);

 private:
  double tool_orientation_;
  JointPlanner planner_;
  Joints near_;
};

/// One of the errors of a TargetResult.
using TargetError = std::optional<Eigen::Vector2d> TargetResult::*;

/// Lengths of an error where it is known, metres, of the targets whose id begins with `prefix`.
std::vector<double> error_lengths(const std::vector<TargetResult>& results, TargetError error,
                                  const std::string& prefix = "");

/// Their mean; NaN when there are none.
double mean_error(const std::vector<TargetResult>& results, TargetError error,
                  const std::string& prefix = "");

/// Figures over the targets that were measured; empty when there are none. The camera's are added
/// by who has it.
struct ServoFigures {
  std::size_t targets{0}, reached{0};
  double iterations_median{0.0};
  double seconds_per_target{0.0};
  std::optional<Summary> before_own, after_own, before_truth, after_truth;  ///< metres
  std::optional<FrameCounts> frames;  ///< of the camera while it was open
};

ServoFigures figures_of(const std::vector<TargetResult>& results);

}  // namespace planar
