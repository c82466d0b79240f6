#include "camera/lens.h"

#include <cmath>

#include "camera/radial_map.h"
#include "core/units.h"

namespace planar::lens {
namespace {

Polynomial polynomial(std::initializer_list<double> coefficients) {
  Polynomial result(static_cast<Eigen::Index>(coefficients.size()));
  std::copy(coefficients.begin(), coefficients.end(), result.data());
  return result;
}

RadialMap radial_map(const PlumbBob& c) {
  return RadialMap(polynomial({1.0, c.k1, c.k2, c.k3}), polynomial({1.0}), c.p1, c.p2);
}

RadialMap radial_map(const Rational& c) {
  return RadialMap(polynomial({1.0, c.k1, c.k2, c.k3}), polynomial({1.0, c.k4, c.k5, c.k6}), c.p1,
                   c.p2);
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

}  // namespace planar::lens
