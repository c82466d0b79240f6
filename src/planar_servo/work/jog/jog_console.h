#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/loop/vision/lamp_tip_sensor.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/jog/arm_command.h"
#include "planar_servo/work/jog/jog_arm.h"
#include "planar_servo/work/jog/lamp_finder.h"

namespace planar {

/// A targets.csv to which taught places are appended, a whole line at a time.
class TaughtTargets {
 public:
  /// Continues the file that is there. A file that is empty or missing is begun with the first
  /// target. Throws InputError naming bad rows, when the columns are not id, x_mm, y_mm and perhaps
  /// phi_deg in this order, when the last line has no end, and when the file cannot be written.
  explicit TaughtTargets(std::filesystem::path path);

  /// Appends a target, without its direction in a table without directions. Throws InputError for
  /// an id that is taken or cannot be one; the file is then unchanged.
  void append(const TargetRow& target);

  /// Throws InputError that names the ids there are for an id that is not among them.
  const TargetRow& at(const std::string& id) const;

 private:
  std::filesystem::path path_;
  bool has_phi_{true};
  std::vector<TargetRow> targets_;
};

/// Moves a cell by hand, one command at a time. Nothing changes for a motion that is too long or
/// leaves the workspace or a motor's limits. From outside the workspace only ways that lead towards
/// it are open.
class JogConsole {
 public:
  /// Opens the console and moves nothing. With an empty path `teach` nothing can be taught. `stop`
  /// is as in PlanarRobot::stop_when(), `announce` as for JogArm(). Throws InputError for a table
  /// that cannot be appended to.
  JogConsole(const CalibratedCell& cell, CellDevices& devices, const std::filesystem::path& teach,
             const std::function<bool()>& stop = {}, Announce announce = {});

  /// Does what is ordered and says what was done. Throws InputError for what cannot be, WorkError
  /// for what failed, and StopRequested, which says where the arm stands, when it was stopped.
  std::string perform(const ArmCommand& command);

  JogArm& arm() { return arm_; }
  /// Returns where the end point was seen, if it was since the arm moved last.
  std::optional<Eigen::Vector2d> seen() const;

 private:
  std::string perform(const EnableCommand& command);
  std::string perform(const HomeCommand& command);
  std::string perform(const MarkCommand& command);
  std::string perform(const TurnCommand& command);
  std::string perform(const StepCommand& command);
  std::string perform(const GoCommand& command);
  std::string perform(const WhereCommand& /*command*/) { return arm_.where(); }
  std::string perform(const LookCommand& command);
  std::string perform(const FindCommand& command);
  std::string perform(const FocusCommand& /*command*/) { return lamps_.focus(); }
  std::string perform(const SaveCommand& command);
  std::string perform(const ExposeCommand& command);
  std::string perform(const TeachCommand& command);

  std::size_t home_by_sight(bool nearest_turn);
  /// Says that the camera is looked through, for some frames beside a whole one.
  void announce_look(int frames);
  TipMeasurement measure();

  /// The end point as it was seen with the motors at these positions.
  struct Seen {
    Eigen::Vector2d p;
    Pulses pulses;
  };

  CalibratedCell cell_;
  CellDevices& devices_;
  Announce announce_;
  JogArm arm_;
  LampFinder lamps_;
  std::optional<LampTipSensor> sensor_;  ///< empty while the cell's vision is not calibrated
  std::optional<TaughtTargets> taught_;
  std::optional<Seen> seen_;
};

}  // namespace planar
