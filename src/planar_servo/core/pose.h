#pragma once

#include <Eigen/Geometry>

#include "planar_servo/core/plane_geometry.h"

namespace planar {

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

}  // namespace planar
