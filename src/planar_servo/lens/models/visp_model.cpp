#include "planar_servo/lens/models/visp_model.h"

#include "planar_servo/lens/radial_map.h"

namespace planar {

namespace {

std::optional<lens::Mapped> scaled(double coefficient, const Eigen::Vector2d& xy) {
  return lens::RadialMap(lens::polynomial({1.0, coefficient})).distort(xy);
}

}  // namespace

VispModel VispModel::with(const Intrinsics& k, const Coefficients& c) {
  return {k, c[0], c[1]};
}

VispModel::Coefficients VispModel::coefficients() const {
  return {kud, kdu};
}

std::optional<lens::Mapped> VispModel::distort(const Eigen::Vector2d& xy) const {
  return scaled(kud, xy);
}

std::optional<lens::Mapped> VispModel::undistort(const Eigen::Vector2d& xy) const {
  return scaled(kdu, xy);
}

VispModel VispModel::sample() {
  return {kSampleIntrinsics, 0.05, -0.047};
}

}  // namespace planar
