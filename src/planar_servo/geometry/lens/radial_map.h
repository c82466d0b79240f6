#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <optional>

#include "planar_servo/geometry/lens/camera_model.h"

namespace planar::lens {

/// Holds the coefficients of a polynomial of degree 7 or less, the constant first, and never
/// allocates memory on the heap.
using Polynomial = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 8, 1>;

Polynomial polynomial(std::initializer_list<double> coefficients);

double value(const Polynomial& a, double s);

/// Returns whether the polynomial is positive on the whole interval [0, end]. Its Bernstein
/// coefficients decide, and the interval is halved while they leave the question open [Farouki &
/// Rajan 1987]. A minimum so close to zero that 20 halvings do not decide counts as not positive.
bool positive_up_to(double end, const Polynomial& a);

/// Holds the coefficients of the terms beside the radial ones: decentring p1, p2 and thin prism
/// s1 ... s4.
struct LateralTerms {
  double p1{0.0}, p2{0.0}, s1{0.0}, s2{0.0}, s3{0.0}, s4{0.0};
};

/// Computes the mapping that all lens models share [Brown 1966, OpenCV]: with s = x^2 + y^2,
///     x_d = x N(s) / D(s) + 2 p1 x y + p2 (s + 2 x^2) + s1 s + s2 s^2
///     y_d = y N(s) / D(s) + p1 (s + 2 y^2) + 2 p2 x y + s3 s + s4 s^2.
/// Its range is where r N(r^2) / D(r^2) still grows from the axis outwards, D has no zero on the
/// way and the Jacobian's determinant is positive.
class RadialMap {
 public:
  explicit RadialMap(const Polynomial& numerator, const Polynomial& denominator = one(),
                     const LateralTerms& lateral = {});

  /// Returns the distorted point of `xy`. Empty outside the range.
  std::optional<Mapped> distort(const Eigen::Vector2d& xy) const;

  /// Returns the point that distort() maps to `xy_d`, found by damped Newton steps inside the
  /// range. Empty when there is no such point in the range.
  std::optional<Mapped> undistort(const Eigen::Vector2d& xy_d) const;

 private:
  static Polynomial one() { return Polynomial::Ones(1); }

  Polynomial numerator_;
  Polynomial denominator_;
  Polynomial growth_;  ///< D^2 times the derivative of r N / D by r, as a polynomial of s
  LateralTerms lateral_;
};

}  // namespace planar::lens
