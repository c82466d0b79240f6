#pragma once

#include <array>
#include <optional>

#include "planar_servo/lens/intrinsics.h"
#include "planar_servo/lens/mapped.h"

namespace planar {

/// Is OpenCV's plumb-bob model [Brown 1966] with the radial coefficients k1, k2, k3 and the
/// decentring ones p1, p2.
struct PlumbBob {
  static constexpr const char* kName = "plumb_bob";
  static constexpr bool kUndistortsExactly = true;
  using Coefficients = std::array<double, 5>;

  Intrinsics k;
  double k1{0.0}, k2{0.0}, p1{0.0}, p2{0.0}, k3{0.0};

  static PlumbBob with(const Intrinsics& k, const Coefficients& c);
  Coefficients coefficients() const;
  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const;
  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const;
  static PlumbBob sample();
};

}  // namespace planar
