#pragma once

#include <Eigen/Geometry>

namespace planar {

/// Pose X_AB of frame B in frame A: p_A = X_AB * p_B, and X_AC = X_AB * X_BC. Metres.
using Pose = Eigen::Isometry3d;

/// End point of the arm and direction of its tool in the base frame (or in the workplane, which is
/// the base raised to the lamps' height): p in metres, phi in radians from x to y.
struct TipPose {
  Eigen::Vector2d p{0.0, 0.0};
  double phi{0.0};
};

/// Angle in (-pi, pi] that differs from `angle` by whole turns.
double wrap_angle(double angle);

/// The angle among `angle` + 2 pi k that lies nearest to `reference`.
double nearest_branch(double angle, double reference);

/// Rotation of the plane by `angle`, from x to y.
Eigen::Matrix2d rotation2d(double angle);

/// Rotation by the vector `w`: about w/|w| by |w| radians.
Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& w);

}  // namespace planar
