#include "planar_servo/core/plane_geometry.h"

#include <Eigen/Geometry>
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

}  // namespace planar
