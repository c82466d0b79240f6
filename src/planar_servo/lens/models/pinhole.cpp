#include "planar_servo/lens/models/pinhole.h"

namespace planar {

using lens::Mapped;

Pinhole Pinhole::with(const Intrinsics& k, const Coefficients&) {
  return {k};
}

Pinhole::Coefficients Pinhole::coefficients() const {
  return {};
}

std::optional<Mapped> Pinhole::distort(const Eigen::Vector2d& xy) const {
  return Mapped{xy};
}

std::optional<Mapped> Pinhole::undistort(const Eigen::Vector2d& xy) const {
  return Mapped{xy};
}

Pinhole Pinhole::sample() {
  return {kSampleIntrinsics};
}

}  // namespace planar
