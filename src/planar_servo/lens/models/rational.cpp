#include "planar_servo/lens/models/rational.h"

#include "planar_servo/lens/radial_map.h"

namespace planar {

lens::RadialMap Rational::map_with(const lens::LateralTerms& lateral) const {
  return lens::RadialMap(lens::polynomial({1.0, k1, k2, k3}), lens::polynomial({1.0, k4, k5, k6}),
                         lateral);
}

Rational Rational::with(const Intrinsics& k, const Coefficients& c) {
  return {k, c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]};
}

Rational::Coefficients Rational::coefficients() const {
  return {k1, k2, p1, p2, k3, k4, k5, k6};
}

std::optional<lens::Mapped> Rational::distort(const Eigen::Vector2d& xy) const {
  return map_with({p1, p2}).distort(xy);
}

std::optional<lens::Mapped> Rational::undistort(const Eigen::Vector2d& xy) const {
  return map_with({p1, p2}).undistort(xy);
}

Rational Rational::sample() {
  return {kSampleIntrinsics, 0.3, 0.02, -2e-4, 5e-4, 0.001, 0.42, 0.06, 0.002};
}

}  // namespace planar
