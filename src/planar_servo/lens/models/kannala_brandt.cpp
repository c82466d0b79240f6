#include "planar_servo/lens/models/kannala_brandt.h"

#include <cmath>

#include "planar_servo/core/units.h"
#include "planar_servo/lens/radial_map.h"

namespace planar {

namespace {

using lens::Mapped;

/// Returns the mapping of the plane of ray angles (theta cos phi, theta sin phi).
lens::RadialMap angle_map(const KannalaBrandt& c) {
  return lens::RadialMap(lens::polynomial({1.0, c.k1, c.k2, c.k3, c.k4}));
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

KannalaBrandt KannalaBrandt::with(const Intrinsics& k, const Coefficients& c) {
  return {k, c[0], c[1], c[2], c[3]};
}

KannalaBrandt::Coefficients KannalaBrandt::coefficients() const {
  return {k1, k2, k3, k4};
}

std::optional<Mapped> KannalaBrandt::distort(const Eigen::Vector2d& xy) const {
  const Mapped angle = angle_from_tangent(xy);
  auto distorted = angle_map(*this).distort(angle.xy);
  if (distorted) distorted->J *= angle.J;
  return distorted;
}

std::optional<Mapped> KannalaBrandt::undistort(const Eigen::Vector2d& xy) const {
  const auto angle = angle_map(*this).undistort(xy);
  if (!angle) return std::nullopt;
  auto tangent = tangent_from_angle(angle->xy);
  if (tangent) tangent->J *= angle->J;
  return tangent;
}

KannalaBrandt KannalaBrandt::sample() {
  return {kSampleIntrinsics, -0.03, 0.006, -0.002, 3e-4};
}

}  // namespace planar
