#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/text.h"
#include "planar_servo/loop/servo/position_servo.h"
#include "planar_servo/loop/servo/servo_result.h"

namespace planar {

class Columns;

/// What a move of a certificate is judged for.
enum class CertificatePart {
  kPose,       ///< the poses in their order, for AP, RP and drift
  kDirection,  ///< a pose from one of several directions, for vAP
  kWorkspace,  ///< a target somewhere in the workspace
};

constexpr Named<CertificatePart> kCertificateParts[] = {{CertificatePart::kPose, "pose"},
                                                        {CertificatePart::kDirection, "direction"},
                                                        {CertificatePart::kWorkspace, "workspace"}};

/// One move whose end is judged.
struct CertificateMove {
  std::string id;
  CertificatePart part{CertificatePart::kPose};
  std::string pose;  ///< "P1"; empty in the workspace
  std::string from;  ///< direction of the approach, "+x"; empty unless it is examined
  int cycle{0};      ///< from 1; 0 in the workspace
  Eigen::Vector2d p_d{0.0, 0.0};
  /// Where the arm comes from. It goes there first unless it stands there.
  std::optional<Eigen::Vector2d> p_before{};
};

/// A move and how its end was judged: a row of cycles.csv. Metres and radians, base frame.
struct JudgedMove {
  CertificateMove move;  ///< p_before is not in the table
  ServoStatus status{ServoStatus::kRefused};
  std::string utc;  ///< when it ended, "2026-11-23T02:00:00Z"
  double seconds{0.0};
  /// By the judge: attained minus commanded. Empty where it was not judged.
  std::optional<Eigen::Vector2d> error;
  std::optional<double> turn_error;  ///< the same for the tool's direction, where it is judged
  double judge_sigma{0.0};           ///< standard uncertainty of the judge per axis
  /// By the cell's own view: attained minus commanded, after the first move and at the end.
  std::optional<Eigen::Vector2d> landing_own, error_own;
  std::optional<double> sigma_vision;  ///< of the last look by its frames' noise, per axis
  std::optional<double> stop_below;    ///< the servo was content below this error

  /// Returns whether the move counts: it reached its target and was judged.
  bool counts() const { return status == ServoStatus::kReached && error; }
};

// The table grows: the header first, then a line at a time.
std::string cycles_header(const std::vector<std::string>& remarks);
std::string cycle_line(const JudgedMove& move);

/// Reads cycles.csv. A move outside the workspace has a pose from P1 to P5. Throws InputError
/// naming FILE:LINE of each bad row. A table without rows is a run that has just begun.
std::vector<JudgedMove> read_cycles(const std::filesystem::path& path);

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
  std::optional<Eigen::Vector2d> before_own, after_own;        ///< by the compensated vision
  std::optional<Eigen::Vector2d> before_judged, after_judged;  ///< where truth or tracker watches
  /// Vision minus truth at the last measurement, before and after compensation.
  std::optional<Eigen::Vector2d> vision_raw, vision_compensated;
  /// Where the servo believed the end point at the last measurement, minus truth.
  std::optional<Eigen::Vector2d> believed;
  std::optional<double> uncertainty_m;   ///< of that place and of the target, per axis
  double sigma_target_m{0.0};            ///< the target's share of it, by the work on which it lies
  std::optional<double> sigma_judged_m;  ///< of `after_judged` per axis, where a tracker watches
  std::string not_judged;                ///< why the tracker did not judge; empty otherwise

  bool judged_by_tracker() const { return sigma_judged_m || !not_judged.empty(); }
};

// The table grows: the header first, then a line at a time.
std::string results_header(const std::vector<std::string>& remarks = {});
std::string result_line(const TargetResult& result);
/// Returns the columns with the fields of this row.
Columns result_columns(const TargetResult& result);

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
