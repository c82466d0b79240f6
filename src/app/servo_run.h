#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/cell_devices.h"
#include "app/lamp_tip_sensor.h"
#include "core/statistics.h"
#include "files/cell_file.h"
#include "files/tables.h"
#include "servo/position_servo.h"

namespace planar {

struct ServoRequest {
  CellSettings cell;
  std::vector<TargetRow> targets;
  CenterMethod center{CenterMethod::kAuto};
  bool use_error_map{true};
  std::filesystem::path out;  ///< steps.csv and results.csv grow here, a line at a time
  bool resume{false};         ///< leave out targets that results.csv holds
  std::function<void(std::size_t done, std::size_t all)> progress;  ///< may be empty
};

/// One target's outcome. Errors are vectors from the target to the end point, base frame, metres.
struct TargetResult {
  std::string id;
  Eigen::Vector2d p_d{0.0, 0.0};
  ServoStatus status{ServoStatus::kRefused};
  std::string reason;
  int iterations{0};
  double seconds{0.0};
  std::optional<Eigen::Vector2d> before_own, after_own;      ///< by the compensated vision
  std::optional<Eigen::Vector2d> before_truth, after_truth;  ///< where a truth watches
  /// Vision minus truth at the last measurement, before and after compensation.
  std::optional<Eigen::Vector2d> vision_raw, vision_compensated;
  double uncertainty_m{0.0};  ///< of the last measurement, per axis
};

/// Every target in turn: an open-loop move, then corrections by vision. Targets that fail are
/// results like the others, unless a device fails: that throws WorkError, with all that was done
/// in the files. Throws InputError when the folder holds a run already and `resume` is not set.
std::vector<TargetResult> run_servo(const ServoRequest& request, CellDevices& devices);

/// The joints and pulses that each target's first, open-loop move would command, without any
/// device; a refusal in words where it would not move.
struct DryRunRow {
  std::string id;
  JointPlan plan;
  Pulses pulses{0, 0, 0};
};
std::vector<DryRunRow> dry_run(const CellSettings& cell, const std::vector<TargetRow>& targets);

/// One of the errors of a TargetResult.
using TargetError = std::optional<Eigen::Vector2d> TargetResult::*;

/// Lengths of an error where it is known, metres, of the targets whose id begins with `prefix`.
std::vector<double> error_lengths(const std::vector<TargetResult>& results, TargetError error,
                                  const std::string& prefix = "");

/// Their mean; NaN when there are none.
double mean_error(const std::vector<TargetResult>& results, TargetError error,
                  const std::string& prefix = "");

/// Figures over the targets that were measured; empty when there are none.
struct ServoFigures {
  std::size_t targets{0}, reached{0};
  double iterations_median{0.0};
  double seconds_per_target{0.0};
  std::optional<Summary> before_own, after_own, before_truth, after_truth;  ///< metres
};

ServoFigures figures_of(const std::vector<TargetResult>& results);

}  // namespace planar
