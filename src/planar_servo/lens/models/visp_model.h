#pragma once

#include <array>
#include <optional>

#include "planar_servo/lens/intrinsics.h"
#include "planar_servo/lens/mapped.h"

namespace planar {

/// Is ViSP's perspective model [vpCameraParameters]: x_d = x (1 + kud r^2) one way and
/// x = x_d (1 + kdu r_d^2) the other. The fit finds both coefficients; neither follows from the
/// other.
struct VispModel {
  static constexpr const char* kName = "visp";
  static constexpr bool kUndistortsExactly = false;
  using Coefficients = std::array<double, 2>;

  Intrinsics k;
  double kud{0.0}, kdu{0.0};

  static VispModel with(const Intrinsics& k, const Coefficients& c);
  Coefficients coefficients() const;
  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const;
  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const;
  static VispModel sample();
};

}  // namespace planar
