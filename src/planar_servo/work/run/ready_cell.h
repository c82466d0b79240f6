#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/geometry/arm/joint_planner.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/hardware/robot/homing.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "planar_servo/loop/health/cause.h"
#include "planar_servo/loop/servo/position_servo.h"
#include "planar_servo/loop/vision/found_landings.h"
#include "planar_servo/loop/vision/lamp_tip_sensor.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/workpiece/find_work.h"

namespace planar {

/// Returns what is known so far of a planner's arm, from the cell's arm_learned file unless there
/// is none, it is to be forgotten, or it belongs to another arm or map, which is logged. Throws
/// InputError for a file with faults.
LearnedArm remembered_arm(const CellSettings& cell, const JointPlanner& planner, bool forgets);

/// Keeps what a run learns of its arm in the cell's arm_learned file, where it names one: every ten
/// minutes and at the end.
class ArmMemory {
 public:
  /// Takes the landings, which must outlive it. The file is made from what the cell names now.
  ArmMemory(const CellSettings& cell, const LearningLandings& landings);
  /// Keeps the last lessons. A file that cannot be written is only logged.
  ~ArmMemory();
  ArmMemory(const ArmMemory&) = delete;
  ArmMemory& operator=(const ArmMemory&) = delete;

  /// Throws WorkError when the file cannot be written.
  void keep_if_due(double now_s);

 private:
  void keep();

  std::filesystem::path file_;
  std::vector<Origin> origins_;
  const LearningLandings& landings_;
  int kept_lessons_{0};
  std::optional<double> kept_s_;
};

/// Where moves end, and who keeps what is learned of that.
struct KeptLandings {
  std::unique_ptr<LandingModel> model{};  ///< none where landings are not estimated
  std::unique_ptr<ArmMemory> memory{};    ///< none where nothing is learned or kept
};

/// Where a run's files go.
struct OutFolder {
  /// steps.csv and results.csv grow here, a line at a time. Empty: nothing is written.
  std::filesystem::path path{};
  bool resume{false};  ///< continues the run that the folder holds
};

/// What of a cell is accepted although it speaks against moving.
struct AcceptedRisks {
  bool stale{false};   ///< files that do not belong together
  bool map{false};     ///< an error map whose fit speaks against it
  bool doubts{false};  ///< the next target is tried even when the cell itself is in doubt
};

/// How a cell closes its loop.
struct ServoPolicy {
  CenterMethod center{CenterMethod::kAuto};  ///< the way in which lamps' centres are measured
  bool checks_health{true};  ///< checks before the first target whether the cell is as it was
  /// How long ago the cell was found well by a check that counts as the first one, seconds.
  std::optional<double> checked_s_ago{};
  /// Holds the arm where a look is uncertain or not what the calibration promises. Without it only
  /// the default GuardLimits hold the arm, whatever the noise.
  bool guards_looks{true};
  /// Positions by all looks at a target and what is known of arm and vision; else the whole error
  /// of the last look is corrected.
  bool estimates_landings{true};
  /// Learns the arm from looks, and keeps what it learns where the cell names an arm_learned file.
  bool learns{false};
  bool forgets{false};  ///< ignores what that file holds at first
};

/// A cell, how it closes its loop, and who is asked and told meanwhile.
struct ServoRequest {
  std::shared_ptr<const CalibratedCell> cell;  ///< without its error map, nothing is compensated
  OutFolder folder{};
  AcceptedRisks accepted{};
  ServoPolicy policy{};
  /// Is asked about drives that lost their position on the way, too. Empty: they may not be homed.
  MayHome may_home{};
  std::function<bool()> stop{};  ///< asked during every move; see PlanarRobot::stop_when()
  /// Judges the first look and the end at every target of a cell without a truth. May be empty.
  std::shared_ptr<Judge> judge{};
  /// Is told the places (base frame) of each check of the cell that begins, and nothing once it has
  /// ended. May be empty.
  std::function<void(const std::optional<std::vector<Eigen::Vector2d>>&)> checking{};
  /// Is told what each check of the cell has found, nothing where it is well. May be empty.
  std::function<void(const std::vector<HealthFinding>&)> found{};
  /// The works on which the targets lie, which are looked at again every minute; null for none.
  std::shared_ptr<const LaidWorks> works{};
};

/// A cell that is about to move by vision: its files are there and belong together, and it is
/// checked before anything depends on it. It waits for lost devices.
class ReadyCell {
 public:
  /// Nothing moves or is switched on. Throws InputError for files that are missing or do not belong
  /// together, unless the request accepts that.
  ReadyCell(const ServoRequest& request, CellDevices& devices);

  /// Switches the drives on and moves the camera's region to the lamps.
  void switch_on();

  /// Homes where that is needed. Checks, before the first other motion and every ten minutes after
  /// it, whether the cell still agrees with its files and its calibration. Returns nothing when no
  /// check was due, an empty text when the cell is well, else what is not. Throws WorkError when it
  /// is not well at first.
  std::optional<std::string> examine_if_due();
  /// Returns whether the arm was moved since the first of these checks. Homing counts.
  bool has_moved_on() const { return begun_at_ && robot_.known_pulses() != *begun_at_; }
  /// The same as examine_if_due() once the work is done, if the last check was more than a minute
  /// ago.
  std::optional<std::string> examine_at_end();

  /// Saves every ten minutes what was learned of the arm.
  void keep_lessons_if_due();

  /// The most recoveries of drives for one target. A drive that fails more often is broken.
  static constexpr int kMaxDriveRecoveries = 3;
  /// The most failures of the camera at one target or during a check of the cell. One that fails
  /// more often is broken.
  static constexpr int kMaxCameraFailures = 20;

  /// Makes one attempt at what `id` names, and makes it again after a drive that failed is back,
  /// but at most `recoveries_left` times.
  template <typename Attempt>
  auto with_drives(const std::string& id, int& recoveries_left, const Attempt& attempt) {
    while (true) {
      try {
        return attempt();
      } catch (const StoppedByHand&) {
        throw;
      } catch (const DriveError& error) {
        if (recoveries_left-- == 0) throw;
        recover_drives(id, error.what());
      }
    }
  }
  /// As the function of this name in servo/motion_guard.h does.
  bool wait_for_camera(const std::string& id, const std::string& reason, double deadline_s);

  const CellSettings& settings() const { return cell_->settings; }
  const GuardLimits& limits() const { return limits_; }
  const JointPlanner& planner() const { return cell_->planner; }
  Clock& clock() { return clock_; }
  PlanarRobot& robot() { return robot_; }
  /// Takes the arm to the other side of the base, or as far aside as it may go, where it hides
  /// nothing that was below it. Returns whether it is there.
  bool stand_aside();
  LampTipSensor& sensor() { return sensor_; }
  PositionServo& servo() { return servo_; }
  /// Returns the accepted objections to files that do not belong together.
  const std::vector<std::string>& accepted_stale() const { return accepted_stale_; }
  /// Returns the accepted objections to the error map.
  const std::optional<std::string>& accepted_map() const { return accepted_map_; }
  const FrameSource& camera() const { return camera_; }

 private:
  void home();
  bool was_examined_s_ago(double seconds) const;
  /// Returns what is not well; logs when nothing is known of the cell's health.
  std::string examine();
  std::string look_for_changes(bool first);
  /// Waits for the drives. Throws DriveError when they are not back in time or may not be homed.
  void recover_drives(const std::string& id, const std::string& reason);

  std::shared_ptr<const CalibratedCell> cell_;
  FrameSource& camera_;
  Clock& clock_;
  MayHome may_home_;
  bool check_health_;
  std::function<void(const std::optional<std::vector<Eigen::Vector2d>>&)> checking_;
  std::function<void(const std::vector<HealthFinding>&)> found_;
  std::optional<double> examined_s_;  ///< when the cell was last checked
  std::optional<std::optional<Pulses>>
      begun_at_;  ///< where the arm stood after the first look, if known
  std::vector<std::string> accepted_stale_;
  std::optional<std::string> accepted_map_;
  GuardLimits limits_;
  LampTipSensor sensor_;
  PlanarRobot robot_;
  KeptLandings landings_;
  PositionServo servo_;
};

}  // namespace planar
