#pragma once

#include <Eigen/Core>

namespace planar {

/// The arm's end point p (metres) and its tool's direction phi (radians, from x to y) in the base
/// frame, or in the workplane, which is the base frame raised to the lamps' height.
struct TipPose {
  Eigen::Vector2d p{0.0, 0.0};
  double phi{0.0};
};

/// Returns the angle in (-pi, pi] that differs from `angle` by whole turns.
double wrap_angle(double angle);

/// Returns the angle among `angle` + 2 pi k that lies nearest to `reference`.
double nearest_branch(double angle, double reference);

/// Returns the rotation of the plane by `angle` radians, from x to y.
Eigen::Matrix2d rotation2d(double angle);

/// Returns the z component of a x b in the plane. It is positive when the turn from a to b goes
/// from x to y.
inline double cross2d(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace planar
