#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "planar_servo/core/names.h"
#include "planar_servo/core/pose.h"

namespace planar {

/// Who judges a cell: the truth of a virtual one, or the tracker of a real one.
enum class JudgeKind { kTruth, kTracker };

constexpr Named<JudgeKind> kJudgeKinds[] = {{JudgeKind::kTruth, "truth"},
                                            {JudgeKind::kTracker, "tracker"}};

/// How the arm stands, for all that is known without a judge.
struct Standing {
  Eigen::Vector3d theta_c{0.0, 0.0, 0.0};  ///< commanded joints, radians
  std::optional<TipPose> seen{};           ///< the tool by the cell's own vision, base frame
};

/// Where the tool is by somebody who is not the cell's own camera, base frame.
struct JudgedTip {
  std::optional<Eigen::Vector2d> p;  ///< the end point, metres; empty where nobody could tell
  double sigma{0.0};                 ///< of p per axis, without what all answers have in common
  std::string fault;                 ///< why nobody could tell; empty where somebody could
  std::optional<double> phi{};       ///< empty where the judge does not see the tool's direction
};

/// Says where the end point really is, by other means than the cell's own vision.
class Judge {
 public:
  virtual ~Judge() = default;
  virtual JudgeKind kind() const = 0;

  /// Judges the tool, which rests on its way to the target `id` or at it.
  virtual JudgedTip judge(const std::string& id, const Standing& standing) = 0;

  /// Returns the standard deviation per axis of the error that all answers have in common, metres.
  virtual double common_sigma() const = 0;
};

}  // namespace planar
