#pragma once

#include <array>
#include <optional>

#include "planar_servo/lens/intrinsics.h"
#include "planar_servo/lens/mapped.h"

namespace planar {

/// Is Kannala-Brandt's equidistant model as in OpenCV's fisheye [Kannala & Brandt 2006]:
/// theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
struct KannalaBrandt {
  static constexpr const char* kName = "equidistant";
  static constexpr bool kUndistortsExactly = true;
  using Coefficients = std::array<double, 4>;

  Intrinsics k;
  double k1{0.0}, k2{0.0}, k3{0.0}, k4{0.0};

  static KannalaBrandt with(const Intrinsics& k, const Coefficients& c);
  Coefficients coefficients() const;
  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const;
  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const;
  static KannalaBrandt sample();
};

}  // namespace planar
