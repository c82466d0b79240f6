#include "planar_servo/core/pose.h"

#include <cmath>

#include "planar_servo/core/units.h"

namespace planar {

double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

double nearest_branch(double angle, double reference) {
  return reference + std::remainder(angle - reference, 2.0 * kPi);
}

Eigen::Matrix2d rotation2d(double angle) {
  return Eigen::Rotation2Dd(angle).toRotationMatrix();
}

Eigen::Matrix2Xd spiral_over_disc(double radius, Eigen::Index count) {
  const double golden_turn = kPi * (3.0 - std::sqrt(5.0)), n = static_cast<double>(count);
  Eigen::Matrix2Xd places(2, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto at = static_cast<double>(i);
    places.col(i) = radius * std::sqrt((at + 0.5) / n) * rotation2d(at * golden_turn).col(0);
  }
  return places;
}

Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

}  // namespace planar
