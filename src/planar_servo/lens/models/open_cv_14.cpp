#include "planar_servo/lens/models/open_cv_14.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/lens/radial_map.h"

namespace planar {

namespace {

using lens::Mapped;

/// Returns the mapping onto an image plane that is not tilted.
lens::RadialMap upright_map(const OpenCv14& c) {
  return c.map_with({c.p1, c.p2, c.s1, c.s2, c.s3, c.s4});
}

/// Returns the homography from the upright image plane to the tilted one, through the centre of
/// projection. The axis stays where it is [OpenCV, module calib3d].
Eigen::Matrix3d tilt_homography(const OpenCv14& c) {
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(-c.tau_y, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(-c.tau_x, Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();
  Eigen::Matrix3d onto_plane;
  onto_plane << R(2, 2), 0.0, -R(0, 2), 0.0, R(2, 2), -R(1, 2), 0.0, 0.0, 1.0;
  return onto_plane * R;
}

/// Maps a point by the homography H. Empty on and beyond the line that H sends to infinity.
std::optional<Mapped> mapped_by(const Eigen::Matrix3d& H, const Eigen::Vector2d& xy) {
  const Eigen::Vector3d image = H * xy.homogeneous();
  if (!(image.z() > 0.0)) return std::nullopt;
  const Eigen::Vector2d at = image.hnormalized();
  if (!at.allFinite()) return std::nullopt;
  return Mapped{at, (H.topLeftCorner<2, 2>() - at * H.row(2).head<2>()) / image.z()};
}

void require_sensor_in_sight(double tau_x, double tau_y) {
  if (std::abs(tau_x) < kPi / 2.0 && std::abs(tau_y) < kPi / 2.0) return;
  throw InputError("camera with a sensor tilted by " + std::to_string(tau_x) + " and " +
                   std::to_string(tau_y) + " rad; both must be less than a right angle");
}

}  // namespace

OpenCv14 OpenCv14::with(const Intrinsics& k, const Coefficients& c) {
  require_sensor_in_sight(c[12], c[13]);
  return {
      {k, c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]}, c[8], c[9], c[10], c[11], c[12], c[13]};
}

OpenCv14::Coefficients OpenCv14::coefficients() const {
  return {k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tau_x, tau_y};
}

std::optional<Mapped> OpenCv14::distort(const Eigen::Vector2d& xy) const {
  const auto upright = upright_map(*this).distort(xy);
  if (!upright) return std::nullopt;
  auto tilted = mapped_by(tilt_homography(*this), upright->xy);
  if (tilted) tilted->J *= upright->J;
  return tilted;
}

std::optional<Mapped> OpenCv14::undistort(const Eigen::Vector2d& xy) const {
  const auto upright = mapped_by(tilt_homography(*this).inverse(), xy);
  if (!upright) return std::nullopt;
  auto ideal = upright_map(*this).undistort(upright->xy);
  if (ideal) ideal->J *= upright->J;
  return ideal;
}

OpenCv14 OpenCv14::sample() {
  return {Rational::sample(), 4e-4, -2e-4, -3e-4, 1e-4, 0.03, -0.02};
}

}  // namespace planar
