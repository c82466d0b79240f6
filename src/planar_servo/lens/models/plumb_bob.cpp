#include "planar_servo/lens/models/plumb_bob.h"

#include "planar_servo/lens/radial_map.h"

namespace planar {

namespace {

lens::RadialMap map_of(const PlumbBob& c) {
  return lens::RadialMap(lens::polynomial({1.0, c.k1, c.k2, c.k3}), lens::polynomial({1.0}),
                         {c.p1, c.p2});
}

}  // namespace

PlumbBob PlumbBob::with(const Intrinsics& k, const Coefficients& c) {
  return {k, c[0], c[1], c[2], c[3], c[4]};
}

PlumbBob::Coefficients PlumbBob::coefficients() const {
  return {k1, k2, p1, p2, k3};
}

std::optional<lens::Mapped> PlumbBob::distort(const Eigen::Vector2d& xy) const {
  return map_of(*this).distort(xy);
}

std::optional<lens::Mapped> PlumbBob::undistort(const Eigen::Vector2d& xy) const {
  return map_of(*this).undistort(xy);
}

PlumbBob PlumbBob::sample() {
  return {kSampleIntrinsics, -0.12, 0.05, 4e-4, -3e-4, -0.01};
}

}  // namespace planar
