#pragma once

#include <Eigen/Core>

namespace planar {

/// Returns the z component of a x b in the plane. It is positive when the turn from a to b goes
/// from x to y.
inline double cross2d(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Returns the 3 x 3 matrix of the map w -> v x w.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

}  // namespace planar
