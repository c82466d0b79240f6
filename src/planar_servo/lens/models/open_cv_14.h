#pragma once

#include <array>
#include <optional>

#include "planar_servo/lens/models/rational.h"

namespace planar {

/// Is OpenCV's model of 14 coefficients [Louhichi et al. 2007]. To the rational one it adds the
/// thin prism s1 r^2 + s2 r^4 along x and s3 r^2 + s4 r^4 along y, and it sees the result on a
/// sensor turned by tau_x about x and then by tau_y about y (radians, each within a right angle).
struct OpenCv14 : Rational {
  static constexpr const char* kName = "opencv_14";
  static constexpr bool kUndistortsExactly = true;
  using Coefficients = std::array<double, 14>;

  double s1{0.0}, s2{0.0}, s3{0.0}, s4{0.0}, tau_x{0.0}, tau_y{0.0};

  /// Throws InputError for a sensor that is tilted by a right angle or more.
  static OpenCv14 with(const Intrinsics& k, const Coefficients& c);
  Coefficients coefficients() const;
  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const;
  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const;
  static OpenCv14 sample();
};

}  // namespace planar
