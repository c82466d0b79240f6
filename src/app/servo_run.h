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
#include "files/servo_tables.h"
#include "files/tables.h"
#include "servo/position_servo.h"

namespace planar {

struct ServoRequest {
  CellSettings cell;
  std::vector<TargetRow> targets;
  CenterMethod center{CenterMethod::kAuto};
  bool use_error_map{true};
  std::filesystem::path out;  ///< steps.csv and results.csv grow here, a line at a time
  bool resume{false};         ///< leave alone the targets whose results the folder holds
  std::function<void(std::size_t done, std::size_t all)> progress;  ///< may be empty
};

/// Every target in turn: an open-loop move, then corrections by vision. Targets that fail are
/// results like the others, unless a device fails: that throws WorkError, with all that was done
/// in the files. A resumed run's results begin with those that the folder holds. Throws InputError
/// when it holds a run already and `resume` is not set.
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
