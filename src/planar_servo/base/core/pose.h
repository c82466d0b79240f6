#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <string>

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

/// Returns the standard deviation per axis, sqrt(trace / 2), of a covariance in the plane.
inline double per_axis(const Eigen::Matrix2d& covariance) {
  return std::sqrt(0.5 * covariance.trace());
}

/// Returns the z component of a x b in the plane. It is positive when the turn from a to b goes
/// from x to y.
inline double cross2d(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Returns places that fill a disc about the origin evenly, from its middle outwards: a spiral
/// whose places are a golden turn apart.
Eigen::Matrix2Xd spiral_over_disc(double radius, Eigen::Index count);

/// The pose X_AB of frame B in frame A, metres: p_A = X_AB * p_B, and X_AC = X_AB * X_BC.
using Pose = Eigen::Isometry3d;

/// Returns the rotation about w/|w| by |w| radians.
Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& w);

/// Returns the 3 x 3 matrix of the map w -> v x w.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// A point fixed to the base whose base coordinates are known (metres). Monuments DEFINE the base
/// frame.
struct Monument {
  std::string id;
  Eigen::Vector3d p_B{0.0, 0.0, 0.0};
};

/// Fits the rigid motion X_AB that minimises sum |X_AB p_B - p_A|^2 over the columns: a rotation
/// and a translation without scale or mirror [Kabsch 1976; Umeyama 1991]. Throws InputError for
/// points that are not finite or do not determine it (all in one place in 2-D, collinear in 3-D),
/// and std::invalid_argument for sets of different size.
Eigen::Isometry2d fit_rigid_2d(const Eigen::Matrix2Xd& p_A, const Eigen::Matrix2Xd& p_B);
Pose fit_rigid_3d(const Eigen::Matrix3Xd& p_A, const Eigen::Matrix3Xd& p_B);

}  // namespace planar
