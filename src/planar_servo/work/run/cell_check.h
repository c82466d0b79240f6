#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/hardware/robot/homing.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "planar_servo/loop/health/cause.h"
#include "planar_servo/loop/health/health_check.h"
#include "planar_servo/loop/health/health_record.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/loop/vision/lamp_tip_sensor.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/run/dry_run.h"

namespace planar {

/// Checks whether a cell still agrees with its files, before anything depends on it.
class CellCheck {
 public:
  /// Receives why the camera failed; returns true once it is back.
  using CameraWait = std::function<bool(const std::string& reason)>;

  /// Takes a cell with vision, robot, sensor and clock, which must outlive it. The drives must be
  /// on. Both checks continue after a `wait` for the camera; without one they throw WorkError. They
  /// throw what PlanarRobot::move_to() throws.
  CellCheck(const CalibratedCell& cell, PlanarRobot& robot, LampTipSensor& sensor, Clock& clock,
            CameraWait wait = {});

  /// Moves each motor a little, near where the arm stands, and compares what is seen with what was
  /// commanded. Returns what differs from the files, first of all light and focus that differ from
  /// `record`.
  std::vector<HealthFinding> first_moves(const std::optional<HealthRecord>& record = {});

  /// Visits the places again that were kept at the calibration, the nearest first, and the last one
  /// from the other side as well. Places that the cell has barred since are left out, and logged.
  /// Returns the play that is more than half of the approach margin, or else what has changed
  /// since, light and focus first.
  std::vector<HealthFinding> revisit(const HealthRecord& record);

  /// Estimates how long so many first moves and the visits take, seconds.
  double expected_s(int first_moves, const std::vector<HealthPlace>& places) const;

 private:
  std::vector<HealthFinding> faults_in_first_moves(Joints theta);
  std::vector<HealthFinding> changes_since(const HealthRecord& record);
  /// Replaces the findings that a change of light or focus may explain by that change, before the
  /// rest.
  std::vector<HealthFinding> light_first(const HealthRecord& record,
                                         std::vector<HealthFinding> found) const;
  /// Moves and settles. Returns why the arm must not go there, if it must not.
  std::optional<std::string> go_to(const Joints& theta);
  TipMeasurement measure(const TipPose& expected, int frames);
  /// Visits a place again. Returns why it was not seen, if it was not.
  std::variant<Revisit, HealthFinding> visit(const HealthPlace& place);
  /// Visits again the two places where the lamps have moved farthest: an arm that had strayed
  /// arrives now, one that has slipped arrives at neither. Returns why they were not seen.
  std::optional<HealthFinding> visit_again(const std::vector<HealthPlace>& places,
                                           std::vector<Revisit>& revisits);
  /// Looks into the only place that differs, if there is one: either the arm strayed there when it
  /// was recorded, or the view has changed there. Returns the latter, beside a single cause that
  /// may explain it; else the place is left out, and what is not known is logged.
  std::vector<HealthFinding> judge_odd_place(const std::vector<HealthPlace>& places,
                                             std::vector<Revisit>& revisits);
  /// Returns twice the logarithm of the odds that the arm strayed at `place` when it was recorded,
  /// to those that the view has changed there since, where lamps are seen `moved` (metres).
  double odds_of_stray(const HealthPlace& place, const std::vector<HealthPlace>& places,
                       const Eigen::Vector2d& moved);
  /// Returns by how much the end point is seen, compensated, beside where the arm as it was found
  /// brings it; nothing where it is not seen.
  std::optional<Eigen::Vector2d> seen_beside(const Joints& theta);
  /// Looks for play here and, if there seems to be some, at another place: an arm that strays as it
  /// comes from above does so at one of them only.
  std::vector<HealthFinding> play_now(const std::vector<HealthPlace>& places,
                                      const std::vector<Revisit>& revisits);
  /// Approaches the present place, a revisited one that was reached from below, from above. Nothing
  /// moves where that is forbidden.
  std::vector<HealthFinding> play_here(const std::vector<Revisit>& revisits);
  /// Throws WorkError unless the camera comes back.
  void wait_for_camera(const std::string& reason) const;
  /// Returns whether the arm may arrive at a place from where it stands.
  bool allows(const Joints& theta) const;
  std::optional<LampPlaces> look();

  const CellSettings& cell_;
  const VisionCalibration& vision_;
  const JointPlanner& as_found_;  ///< for the arm that was found, if it was
  PlanarRobot& robot_;
  LampTipSensor& sensor_;
  Clock& clock_;
  CameraWait wait_;
  JointPlanner planner_;
  CheckWays ways_;
  CellModel model_;
  std::vector<LampLooks> looks_;  ///< of this check
};

/// The largest cost of a change at the end point with which the arm may still work, metres.
constexpr double kTolerable_m = 20e-6;

/// Sets the limits of place, direction and separation to 1.5 times what the calibration saw.
GuardLimits with_health(GuardLimits limits, const HealthRecord& record);

/// Runs the first moves and, when they are in order, revisits the places of `record`, if there is
/// one. Logs what is done and about how long it takes.
std::vector<HealthFinding> check_cell(CellCheck& check, const std::optional<HealthRecord>& record);
/// Does the same without the first moves.
std::vector<HealthFinding> check_again(CellCheck& check, const HealthRecord& record);

/// Switches the drives on, homes them where that is needed and allowed, and runs check_cell().
/// `stop` is as in PlanarRobot::stop_when(). Throws what require_checkable() and the moves throw.
std::vector<HealthFinding> check_devices(const CalibratedCell& cell, CellDevices& devices,
                                         const MayHome& may_home,
                                         const std::function<bool()>& stop);

/// Returns what was found, a sentence with its remedy for each.
std::string findings_text(const std::vector<HealthFinding>& findings);

/// Returns the findings under the keys `healthy` and `findings`.
nlohmann::ordered_json findings_json(const std::vector<HealthFinding>& findings);

}  // namespace planar
