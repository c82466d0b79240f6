#include "planar_servo/lens/lens.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "planar_servo/core/units.h"
#include "planar_servo/lens/radial_map.h"

namespace planar::lens {
namespace {

Polynomial polynomial(std::initializer_list<double> coefficients) {
  Polynomial result(static_cast<Eigen::Index>(coefficients.size()));
  std::copy(coefficients.begin(), coefficients.end(), result.data());
  return result;
}

RadialMap radial_map(const PlumbBob& c) {
  return RadialMap(polynomial({1.0, c.k1, c.k2, c.k3}), polynomial({1.0}), {c.p1, c.p2});
}

RadialMap rational_map(const Rational& c, const LateralTerms& lateral) {
  return RadialMap(polynomial({1.0, c.k1, c.k2, c.k3}), polynomial({1.0, c.k4, c.k5, c.k6}),
                   lateral);
}

RadialMap radial_map(const Rational& c) {
  return rational_map(c, {c.p1, c.p2});
}

/// On an image plane that is not tilted.
RadialMap upright_map(const OpenCv14& c) {
  return rational_map(c, {c.p1, c.p2, c.s1, c.s2, c.s3, c.s4});
}

/// From the upright image plane to the tilted one, through the centre of projection; the axis stays
/// where it is [OpenCV, module calib3d].
Eigen::Matrix3d tilt_homography(const OpenCv14& c) {
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(-c.tau_y, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(-c.tau_x, Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();
  Eigen::Matrix3d onto_plane;
  onto_plane << R(2, 2), 0.0, -R(0, 2), 0.0, R(2, 2), -R(1, 2), 0.0, 0.0, 1.0;
  return onto_plane * R;
}

/// Empty on and beyond the line that H sends to infinity.
std::optional<Mapped> mapped_by(const Eigen::Matrix3d& H, const Eigen::Vector2d& xy) {
  const Eigen::Vector3d image = H * xy.homogeneous();
  if (!(image.z() > 0.0)) return std::nullopt;
  const Eigen::Vector2d at = image.hnormalized();
  if (!at.allFinite()) return std::nullopt;
  return Mapped{at, (H.topLeftCorner<2, 2>() - at * H.row(2).head<2>()) / image.z()};
}

/// Acts on the plane of ray angles (theta cos phi, theta sin phi).
RadialMap angle_map(const KannalaBrandt& c) {
  return RadialMap(polynomial({1.0, c.k1, c.k2, c.k3, c.k4}));
}

RadialMap one_coefficient(double k) {
  return RadialMap(polynomial({1.0, k}));
}

/// Scales `from` to the length `to_length`, whose derivative by |from| is `slope`.
Mapped rescaled(const Eigen::Vector2d& from, double to_length, double slope) {
  const double length = from.norm();
  if (length < 1e-8) return {from, Eigen::Matrix2d::Identity()};
  const double scale = to_length / length;
  const Eigen::Vector2d along = from / length;
  return {scale * from,
          scale * Eigen::Matrix2d::Identity() + (slope - scale) * along * along.transpose()};
}

Mapped angle_from_tangent(const Eigen::Vector2d& xy) {
  return rescaled(xy, std::atan(xy.norm()), 1.0 / (1.0 + xy.squaredNorm()));
}

std::optional<Mapped> tangent_from_angle(const Eigen::Vector2d& angle) {
  if (!(angle.norm() < kPi / 2.0)) return std::nullopt;
  const double tangent = std::tan(angle.norm());
  return rescaled(angle, tangent, 1.0 + tangent * tangent);
}

}  // namespace

std::optional<Mapped> distort(const Pinhole&, const Eigen::Vector2d& xy) {
  return Mapped{xy};
}
std::optional<Mapped> undistort(const Pinhole&, const Eigen::Vector2d& xy) {
  return Mapped{xy};
}

std::optional<Mapped> distort(const VispModel& camera, const Eigen::Vector2d& xy) {
  return one_coefficient(camera.kud).distort(xy);
}

std::optional<Mapped> undistort(const VispModel& camera, const Eigen::Vector2d& xy) {
  return one_coefficient(camera.kdu).distort(xy);
}

std::optional<Mapped> distort(const PlumbBob& camera, const Eigen::Vector2d& xy) {
  return radial_map(camera).distort(xy);
}

std::optional<Mapped> undistort(const PlumbBob& camera, const Eigen::Vector2d& xy) {
  return radial_map(camera).undistort(xy);
}

std::optional<Mapped> distort(const Rational& camera, const Eigen::Vector2d& xy) {
  return radial_map(camera).distort(xy);
}

std::optional<Mapped> undistort(const Rational& camera, const Eigen::Vector2d& xy) {
  return radial_map(camera).undistort(xy);
}

std::optional<Mapped> distort(const KannalaBrandt& camera, const Eigen::Vector2d& xy) {
  const Mapped angle = angle_from_tangent(xy);
  auto distorted = angle_map(camera).distort(angle.xy);
  if (distorted) distorted->J *= angle.J;
  return distorted;
}

std::optional<Mapped> undistort(const KannalaBrandt& camera, const Eigen::Vector2d& xy) {
  const auto angle = angle_map(camera).undistort(xy);
  if (!angle) return std::nullopt;
  auto tangent = tangent_from_angle(angle->xy);
  if (tangent) tangent->J *= angle->J;
  return tangent;
}

std::optional<Mapped> distort(const OpenCv14& camera, const Eigen::Vector2d& xy) {
  const auto upright = upright_map(camera).distort(xy);
  if (!upright) return std::nullopt;
  auto tilted = mapped_by(tilt_homography(camera), upright->xy);
  if (tilted) tilted->J *= upright->J;
  return tilted;
}

std::optional<Mapped> undistort(const OpenCv14& camera, const Eigen::Vector2d& xy) {
  const auto upright = mapped_by(tilt_homography(camera).inverse(), xy);
  if (!upright) return std::nullopt;
  auto ideal = upright_map(camera).undistort(upright->xy);
  if (ideal) ideal->J *= upright->J;
  return ideal;
}

}  // namespace planar::lens
