#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/servo/position_servo.h"

namespace planar {

/// Holds one target's outcome, a row of results.csv. Errors are vectors from the target to the end
/// point in the base frame, metres.
struct TargetResult {
  std::string id;
  Eigen::Vector2d p_d{0.0, 0.0};
  std::optional<double> phi_d;  ///< radians; empty in tables of earlier versions
  ServoStatus status{ServoStatus::kRefused};
  std::string reason;
  int iterations{0};
  double seconds{0.0};
  std::optional<Eigen::Vector2d> before_own, after_own;      ///< by the compensated vision
  std::optional<Eigen::Vector2d> before_truth, after_truth;  ///< where truth or tracker watches
  /// Vision minus truth at the last measurement, before and after compensation.
  std::optional<Eigen::Vector2d> vision_raw, vision_compensated;
  /// Where the servo believed the end point at the last measurement, minus truth.
  std::optional<Eigen::Vector2d> believed;
  std::optional<double> uncertainty_m;  ///< of that place, per axis
  std::optional<double> sigma_truth_m;  ///< of `after_truth` per axis, where a tracker watches
  std::string not_judged;               ///< why the tracker did not judge; empty otherwise

  bool judged_by_tracker() const { return sigma_truth_m || !not_judged.empty(); }
};

/// Names one of the errors of a result. Each has three columns: its length and its components.
struct ResultError {
  const char* name;
  std::optional<Eigen::Vector2d> TargetResult::*error;

  std::array<std::string, 3> columns() const;
};

/// Returns all errors of a result, in the order of the columns.
const std::vector<ResultError>& result_errors();

// The table grows: the header first, then a line at a time.
std::string results_header();
std::string results_header(const std::vector<std::string>& remarks);
std::string result_line(const TargetResult& result);

/// Writes the whole table anew.
void write_results(const std::filesystem::path& path, const std::string& header,
                   const std::vector<TargetResult>& results);

/// Reads results.csv. Throws InputError naming FILE:LINE of each bad row. A table without rows is
/// an empty run.
std::vector<TargetResult> read_results(const std::filesystem::path& path);

// The table steps.csv grows, too.
std::string steps_header();
std::string step_line(const std::string& id, const ServoStep& step);

/// One step on the way to a target: the distance to it by the servo's own view, metres. Empty where
/// the tool was not measured.
struct StepError {
  std::string target;
  int step{0};  ///< number of corrections made before
  std::optional<double> error;
};

/// Reads the error of each step from steps.csv. Throws InputError naming FILE:LINE of each bad row,
/// and for a missing file.
std::vector<StepError> read_step_errors(const std::filesystem::path& path);

}  // namespace planar
