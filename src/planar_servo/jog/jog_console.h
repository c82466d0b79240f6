#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/robot/planar_robot.h"
#include "planar_servo/tables/target_table.h"
#include "planar_servo/vision/lamp_tip_sensor.h"

namespace planar {

/// Says how bright the lit part of an image is.
struct ExposureReading {
  int peak_level{0};            ///< grey level of the brightest part, without a few hot pixels
  double saturated_share{0.0};  ///< share of the lit pixels that are at 255

  /// Returns true when the lamps use less than half of the grey levels.
  bool too_dark() const;
  /// Returns true when more than 2 % of the lit pixels are saturated.
  bool too_bright() const;
  /// Returns one line with a bar, the figures, and what to do.
  std::string text() const;
};

/// Reads the exposure of an image, which is CV_8UC1 and not empty. Pixels are lit that lie above
/// the middle between the median level and the peak.
ExposureReading read_exposure(const cv::Mat& image);

/// A targets.csv to which taught places are appended, a whole line at a time.
class TaughtTargets {
 public:
  /// Continues the file that is there. A file that is empty or missing is begun with the first
  /// target. Throws InputError naming bad rows, when the columns are not id, x_mm, y_mm, phi_deg in
  /// this order, when the last line has no end, and when the file cannot be written.
  explicit TaughtTargets(std::filesystem::path path);

  /// Appends a target. Throws InputError for an id that is taken or cannot be one; the file is then
  /// unchanged.
  void append(const TargetRow& target);

 private:
  std::filesystem::path path_;
  std::set<std::string> ids_;
};

/// Lets a person move a cell by hand, one command at a time:
///   enable | home [JOINT] | mark JOINT | joint JOINT DEG | x MM | y MM | where | look |
///   exposure US [GAIN_DB] | teach ID
/// Joints count from 1. `joint` turns the motor behind its gear by the angle, and with it what
/// rides on that link. Nothing changes for a command that is wrong and for a motion that is too
/// long or leaves the workspace or a motor's limits. From outside the workspace only ways that lead
/// towards it are open.
class JogConsole {
 public:
  struct Answer {
    bool done{true};
    std::string text;  ///< says what was done, or why it was not
  };

  /// Opens the console and moves nothing. With an empty path `teach` nothing can be taught. `stop`
  /// is as in PlanarRobot::stop_when(). Throws InputError for a table that cannot be appended to
  /// and for files of the cell that cannot be read.
  JogConsole(const CellSettings& cell, CellDevices& devices, const std::filesystem::path& teach,
             const std::function<bool()>& stop = {});

  Answer execute(const std::string& line);

  /// Returns a line for each command.
  static const char* help();

 private:
  using Words = std::vector<std::string>;
  struct Command;
  static const std::vector<Command>& commands();

  std::string enable(const Words& words);
  std::string home(const Words& words);
  std::string mark(const Words& words);
  std::string turn_joint(const Words& words);
  std::string move_x(const Words& words);
  std::string move_y(const Words& words);
  std::string where(const Words& words);
  std::string look(const Words& words);
  std::string expose(const Words& words);
  std::string teach(const Words& words);

  std::string move_by(const Eigen::Vector2d& step);
  std::string move_to(const Joints& theta);
  /// Returns what makes the drives known that do not know their position; empty when all do.
  std::string how_to_home();
  /// Returns what forbids the way from where the arm is to these joints, if anything does.
  std::optional<std::string> refusal(const Joints& theta) const;
  TipMeasurement measure();

  CellSettings cell_;
  CellDevices& devices_;
  JointPlanner planner_;
  PlanarRobot robot_;
  std::optional<LampTipSensor> sensor_;  ///< empty while the cell's vision is not calibrated
  bool compensated_{false};
  std::optional<TaughtTargets> taught_;
  bool enabled_{false};
};

}  // namespace planar
