#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>

#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/geometry/arm/joint_planner.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "planar_servo/machine/device_kinds.h"

namespace planar {

/// Takes a sentence on what the arm begins to do.
using Announce = std::function<void(const std::string&)>;

/// The arm of a cell as a person moves it: enabled, homed, then by short moves of a joint or of the
/// end point, or to a taught place. Joints count from 0. What must not be done throws InputError
/// with its remedy, and nothing has moved then; a motion that fails throws WorkError.
class JogArm {
 public:
  /// Opens the arm and moves nothing. `stop` is as in PlanarRobot::stop_when(). `announce` is told
  /// of anything that takes long, and about how long.
  JogArm(const CalibratedCell& cell, CellDevices& devices, const std::function<bool()>& stop,
         Announce announce);

  /// Switches the drives on, also after a fault.
  void enable();
  /// Searches the home switch of a joint or, without one, of every joint that needs it. Returns how
  /// many were homed.
  std::size_t home(std::optional<int> joint);
  bool homes_by_sight() const { return robot_.homes_by_sight(); }
  /// Homes all joints in this way where one needs it. Returns how many were homed.
  std::size_t home_by(const std::function<void(PlanarRobot&)>& way);
  /// Says that a motor stands at its mark.
  void mark(int joint);

  /// Turns the motor behind its gear, and with it what rides on that link.
  void turn(int joint, double angle);
  /// Moves the end point along the base's axes and keeps the tool's direction. A step that is
  /// stopped leaves the arm beside its line, to which the next step along it returns. Throws
  /// StopRequested with the way that was made.
  void step(const Eigen::Vector2d& step_B);
  /// Moves to a target, by the arm that was found where the cell has one, as planar-servo goes
  /// there before it looks. Returns by which arm, in words.
  std::string go_to(const TargetRow& target);

  /// Takes over from another program part that has moved the arm, or switched it on or off.
  void take_over();

  /// Throws unless the drives are on and know where they stand.
  void require_ready();
  /// Returns what to do about drives that do not know their position; empty when all do.
  std::string how_to_home();

  bool enabled() const { return enabled_; }
  /// These throw DriveError while a drive does not know its position.
  Joints commanded() const { return robot_.commanded_joints(); }
  TipPose tip() const { return planner_.arm().forward(commanded()); }
  std::optional<Pulses> known_pulses() const { return robot_.known_pulses(); }
  /// Says where joints and end point are commanded to, or what to do before that is known.
  std::string where();

 private:
  void require_enabled() const;
  void move_to(const Joints& theta);
  /// Returns the guard of a move that the camera's fault stops. It is empty after a loss of the
  /// camera: a person who watches may move on.
  PlanarRobot::Guard guard();
  /// Returns what forbids the short way from where the arm is to these joints, if anything does.
  std::optional<std::string> refusal(const Joints& theta) const;
  /// Returns the present pose, put back on the line of a step that was cut short here if that led
  /// the same way.
  TipPose on_line(const Eigen::Vector2d& step_B) const;
  double duration_s(const Joints& theta) const;

  CellSettings cell_;
  FrameSource& camera_;
  DriveGroup& drives_;
  Announce announce_;
  JointPlanner planner_;
  PlanarRobot robot_;
  bool enabled_{false};
  /// A step that was cut short: where its line began, its direction, and where the arm rests since.
  struct CutShort {
    TipPose begin;
    Eigen::Vector2d along{1.0, 0.0};
    Joints rest{0.0, 0.0, 0.0};
  };
  std::optional<CutShort> cut_;
};

}  // namespace planar
