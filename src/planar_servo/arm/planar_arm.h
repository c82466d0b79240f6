#pragma once

#include <Eigen/Core>

#include "planar_servo/core/pose.h"

namespace planar {

/// theta1, theta2, theta3 in radians, ALL measured from the base's x axis: theta2 is the absolute
/// direction of link 2, theta3 that of the tool.
using Joints = Eigen::Vector3d;

/// The sense in which joint angles grow, seen from +Z.
enum class Rotation { kCounterclockwise, kClockwise };

/// On which side of the ray base -> P the elbow lies, seen from +Z.
enum class Elbow { kLeft, kRight };

struct ArmGeometry {
  Eigen::Vector2d link_lengths_m{0.3, 0.3};
  Rotation positive_rotation{Rotation::kCounterclockwise};
};

enum class ReachStatus {
  kOk,
  kTooFar,        ///< |p| > L1 + L2
  kTooClose,      ///< |p| < |L1 - L2|
  kUndetermined,  ///< p is the base's axis and the links are equally long: any theta1 will do
};

/// In words, with the rule, for messages.
const char* describe(ReachStatus status);

struct InverseResult {
  ReachStatus status{ReachStatus::kOk};
  Joints theta{0.0, 0.0, 0.0};  ///< valid only when status is kOk
};

/// Kinematics of two links in a plane and a tool turning about their end P, in the base frame B:
///   x = L1 cos(theta1) + L2 cos(theta2),  y = s (L1 sin(theta1) + L2 sin(theta2)),
///   phi = s theta3,  s = +1 where angles grow from x to y, else -1.
/// Every function throws std::invalid_argument for a number that is not finite.
class PlanarArm {
 public:
  /// Throws std::invalid_argument unless both lengths are finite and positive.
  explicit PlanarArm(const ArmGeometry& geometry);

  TipPose forward(const Joints& theta) const;

  /// The solution with the given elbow; each angle is brought to the 2 pi branch nearest `near`.
  /// (The side of the elbow is lost where the arm is stretched: there both solutions agree.)
  InverseResult inverse(const TipPose& target, Elbow elbow, const Joints& near) const;

  /// The solution, of both elbows, whose first two angles lie nearest `near`.
  InverseResult inverse_nearest(const TipPose& target, const Joints& near) const;

  Elbow elbow(const Joints& theta) const;

  /// d(x, y) / d(theta1, theta2).
  Eigen::Matrix2d jacobian(const Joints& theta) const;

  /// |sin(theta2 - theta1)|: 1 at a right angle between the links, 0 where the arm is singular.
  static double manipulability(const Joints& theta);

  /// s of the equations: +1 or -1.
  double sense() const { return sense_; }
  const ArmGeometry& geometry() const { return geometry_; }

 private:
  ArmGeometry geometry_;
  double sense_;
};

}  // namespace planar
