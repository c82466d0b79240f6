#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/files/tables/servo_tables.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/robot/planar_robot.h"
#include "planar_servo/servo/position_servo.h"
#include "planar_servo/vision/lamp_tip_sensor.h"

namespace planar {

struct ServoRequest {
  CellSettings cell;
  CenterMethod center{CenterMethod::kAuto};  ///< how lamps' centres are measured
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
  std::optional<LampPixels> wanted_px;
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
  /// drive, which may have to be homed then, but not more than three times for one target. The
  /// result counts the corrections and the time of all attempts.
  const TargetResult& move_to(const TargetRow& target);

  bool has(const std::string& id) const;
  /// A resumed run's results begin with those that the folder holds.
  const std::vector<TargetResult>& results() const { return results_; }

 private:
  /// One attempt at a target, made again after a drive that failed is back, but not more than
  /// `recoveries_left` times.
  ServoResult with_drives(const std::string& id, int& recoveries_left,
                          const std::function<ServoResult()>& attempt);
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

}  // namespace planar
