#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "planar_servo/base/core/pose.h"

namespace planar {

/// The tip of a tool that need not lie on joint 3's axis, in the frame T, which has its origin at P
/// and turns with the tool: p_tip = P + R(phi) p_TE. Metres.
struct ToolTip {
  Eigen::Vector2d p_TE{0.0, 0.0};
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};
};

/// Returns where P must be for the tip to be at `p_E` with the tool's direction `phi`.
inline Eigen::Vector2d end_point_for(const Eigen::Vector2d& p_E, double phi,
                                     const Eigen::Vector2d& p_TE) {
  return p_E - rotation2d(phi) * p_TE;
}

/// One time at which the tip was brought to the mark: P and direction, base frame.
struct TipAtMark {
  std::string id;
  TipPose pose;
};

/// What poses with the tip at one mark tell.
struct TaughtTip {
  ToolTip tip;
  Eigen::Vector2d mark_B{0.0, 0.0};
  std::vector<Eigen::Vector2d> residuals;  ///< of each pose, base frame, metres
  double sigma{0.0};                       ///< of a pose per axis: stated, or found where larger
};

/// Directions of a tool that are nearer than this to one another count once, radians.
constexpr double kApartDirections = 0.35;

/// Solves P_i + R(phi_i) p_TE = mark by least squares (theory section 20). `sigma` is the standard
/// deviation per axis with which the tip was brought to the mark, metres; where the poses scatter
/// by more, theirs counts. Throws InputError with fewer than three directions that are
/// kApartDirections apart, and WorkError where the poses contradict one another by more than noise
/// of `sigma` explains, naming the one without which the others agree.
TaughtTip teach_tip(const std::vector<TipAtMark>& poses, double sigma);

/// Returns how far the tip is from the mark in a later pose, and the standard deviation of that per
/// axis, metres.
struct TipMiss {
  Eigen::Vector2d off{0.0, 0.0};
  double sigma{0.0};
};
TipMiss miss_of(const TaughtTip& taught, const TipPose& pose);

}  // namespace planar
