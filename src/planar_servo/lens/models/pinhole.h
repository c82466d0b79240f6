#pragma once

#include <array>
#include <optional>

#include "planar_servo/lens/intrinsics.h"
#include "planar_servo/lens/mapped.h"

namespace planar {

/// Models a lens without distortion.
struct Pinhole {
  static constexpr const char* kName = "pinhole";
  static constexpr bool kUndistortsExactly = true;
  using Coefficients = std::array<double, 0>;

  Intrinsics k;

  static Pinhole with(const Intrinsics& k, const Coefficients& c);
  Coefficients coefficients() const;
  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const;
  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const;
  static Pinhole sample();
};

}  // namespace planar
