#pragma once

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/geometry/arm/joint_planner.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/loop/health/health_record.h"
#include "planar_servo/loop/servo/path/path.h"
#include "planar_servo/workpiece/find_work.h"

namespace planar {

/// Says in what order an arm visits places, and which of them it cannot.
struct VisitPlan {
  std::vector<std::size_t> order;
  std::vector<std::string> barred;  ///< a place and what forbids it, each
};

/// Plans where a check of a cell moves the arm. Nothing moves.
class CheckWays {
 public:
  /// The first moves of motors 1 to 3, in which a gear that is off by 0.5 % shows beside the
  /// reducers' eccentricity, radians.
  static Eigen::Vector3d first_moves() { return kDegree * Eigen::Vector3d(40.0, 40.0, 60.0); }

  /// Says whether the lamps of a tool at this pose can be in the camera's view.
  using Views = std::function<bool(const TipPose&)>;

  CheckWays(const CellSettings& cell, Views views);

  /// Returns the present joints where first moves may be made there, or else those of an allowed
  /// place on a ring in the middle of the workspace, the nearest first.
  std::optional<Joints> start(const Joints& present) const;
  /// Returns the joints with one motor turned as far as the first moves want and the cell allows.
  Joints with_motor_turned(const Joints& theta, int motor) const;
  /// Visits from `theta` the nearest place first, always; one that is barred at first may be open
  /// from another place.
  VisitPlan visits(Joints theta, const std::vector<HealthPlace>& places) const;
  /// Returns whether the arm may arrive at `theta` from where it rests and is seen there.
  bool allows(const Joints& from, const Joints& theta) const;

 private:
  const CellSettings& cell_;
  Views views_;
  JointPlanner planner_;
};

/// What the ways of the first check of a cell come to.
struct ForeseenCheck {
  Joints end{0.0, 0.0, 0.0};       ///< where it leaves the arm
  std::optional<Refusal> doubt{};  ///< what of it cannot be done
  bool refused{false};             ///< nothing of it can
};

/// Plans the check of a cell whose arm stands at home. Without vision every place is in view.
/// Throws InputError for faults of its health file.
ForeseenCheck foresee_check(const CalibratedCell& cell);

/// Says that places of a check are left out; `places` is how many there are.
std::string barred_text(const std::vector<std::string>& barred, std::size_t places);

/// Holds the joints and pulses that a target's first, open-loop move would command. The plan holds
/// a refusal in words where the arm would not move.
struct DryRunRow {
  std::string id;
  JointPlan plan;
  Pulses pulses{0, 0, 0};
  std::vector<Eigen::Vector2d> way_B{};  ///< of the end point, to draw it
};

/// Plans the first move to one target after the other. It needs no device.
class DryRun {
 public:
  /// Starts at these joints. Throws InputError for a cell whose arm is yet to be found.
  DryRun(const CalibratedCell& cell, const Joints& start);
  /// Plans the move to a target from where the arm stands after the moves planned before.
  DryRunRow first_move(const TargetRow& target);

 private:
  double tool_orientation_;
  JointPlanner planner_;
  ServoSettings servo_;
  Joints near_;
};

/// Returns the pose of a target. One that names no direction takes `tool_orientation` (radians).
TipPose target_pose(const TargetRow& target, double tool_orientation);
/// Returns where the end point P is to be for the tip of the target's tool to be there.
TipPose end_point_pose(const TargetRow& target, double tool_orientation);

/// Refuses the targets of these rows at which the error map, if there is one, is not valid.
void refuse_outside_map(std::vector<DryRunRow>& rows, const std::vector<TargetRow>& targets,
                        const CalibratedCell& cell);

/// Plans the first move to every target in turn.
std::vector<DryRunRow> first_moves_to(const CalibratedCell& cell, const Joints& start,
                                      const std::vector<TargetRow>& targets);

/// Returns those that are refused.
std::vector<DryRunRow> refused_of(std::vector<DryRunRow> rows);

/// Returns a line for each target: its joints and pulses, or why it is refused.
std::string dry_run_text(const std::vector<DryRunRow>& rows);

/// Returns one target's `target`, `status` ("planned" or "refused"), `reason`, and what the first
/// move commands: `theta_deg` and `pulses`.
nlohmann::ordered_json first_move_answer(const DryRunRow& row);

/// Returns every target's answer under the key `moves`.
nlohmann::json dry_run_json(const std::vector<DryRunRow>& rows);

/// Returns what can hardly be meant in a table of targets: places written in metres, which are all
/// within a millimetre of the base's axes, and directions in radians.
std::vector<Refusal> target_doubts(const std::vector<TargetRow>& targets,
                                   const Workspace& workspace);

/// Returns what can hardly be meant in a table of targets on a work: places written in metres,
/// which are all within a millimetre of its drawing's axes.
std::optional<Refusal> doubt_on_work(const std::vector<TargetRow>& drawn, const FoundWork& work);

/// Logs these doubts. Throws InputError for places in metres if none of them lies in the workspace.
/// `file` names the table.
void question_targets(const std::vector<TargetRow>& targets, const Workspace& workspace,
                      const std::filesystem::path& file);

// Pages of what would be done, for whoever checks it before anything moves: the ways in the
// workspace, and by themselves.

/// `remarks` say what was assumed of the path's file, or left out.
std::string plan_page(const Workspace& workspace, const std::filesystem::path& file,
                      const Path& path, const std::vector<std::string>& remarks);

/// `rows` are the first moves to these targets.
std::string plan_page(const Workspace& workspace, const std::filesystem::path& file,
                      const std::vector<TargetRow>& targets, const std::vector<DryRunRow>& rows,
                      const std::vector<std::string>& remarks);

}  // namespace planar
