#pragma once

#include <array>
#include <optional>

#include "planar_servo/lens/intrinsics.h"
#include "planar_servo/lens/mapped.h"

namespace planar {

namespace lens {
class RadialMap;
struct LateralTerms;
}  // namespace lens

/// Is OpenCV's rational model with the radial factor (1 + k1 r^2 + k2 r^4 + k3 r^6) /
/// (1 + k4 r^2 + k5 r^4 + k6 r^6) and decentring p1, p2.
struct Rational {
  static constexpr const char* kName = "rational_polynomial";
  static constexpr bool kUndistortsExactly = true;
  using Coefficients = std::array<double, 8>;

  Intrinsics k;
  double k1{0.0}, k2{0.0}, p1{0.0}, p2{0.0}, k3{0.0}, k4{0.0}, k5{0.0}, k6{0.0};

  static Rational with(const Intrinsics& k, const Coefficients& c);
  Coefficients coefficients() const;
  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const;
  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const;
  static Rational sample();

  /// Returns the mapping with these terms beside the radial ones.
  lens::RadialMap map_with(const lens::LateralTerms& lateral) const;
};

}  // namespace planar
