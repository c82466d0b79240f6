#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/core/names.h"
#include "planar_servo/servo/servo_result.h"

namespace planar {

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
  std::optional<double> sigma_vision;  ///< of one frame at the last look, per axis
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

}  // namespace planar
