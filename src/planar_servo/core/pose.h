#pragma once

#include <Eigen/Geometry>

namespace planar {

/// The pose X_AB of frame B in frame A, metres: p_A = X_AB * p_B, and X_AC = X_AB * X_BC.
using Pose = Eigen::Isometry3d;

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

/// Returns the rotation about w/|w| by |w| radians.
Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& w);

}  // namespace planar
