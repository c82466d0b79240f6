#pragma once

#include <Eigen/Core>
#include <limits>

namespace planar {

/// The polynomial that a radial basis function map stands on, as a basis q(p) of scaled coordinates
/// (p - origin) / scale: degree 2 is [1, x, y, x^2, xy, y^2], degree 1 is [1, x, y], degree 0 is
/// [1], degree -1 is empty. With the tool's direction d = (cos phi, sin phi) its two components
/// come last: their coefficients B d hold an error that is fixed in the tool's frame, R(phi) t, and
/// its mirror image.
struct TailBasis {
  int degree{1};
  Eigen::Vector2d origin{0.0, 0.0};  ///< metres
  double scale{1.0};                 ///< metres
  bool with_direction{false};

  Eigen::Index terms() const {
    return (degree + 1) * (degree + 2) / 2 + (with_direction ? kDirectionTerms : 0);
  }
  /// q, of `terms()` elements; the direction counts only in a basis that has it.
  Eigen::VectorXd at(const Eigen::Vector2d& p,
                     const Eigen::Vector2d& direction = unknown_direction()) const;
  /// q of each column of `positions` and `directions`, one row each.
  Eigen::MatrixXd at_each(const Eigen::Matrix2Xd& positions,
                          const Eigen::Matrix2Xd& directions = {}) const;

  static constexpr Eigen::Index kDirectionTerms = 2;
  /// NaN, as what is made of it where a direction is needed.
  static Eigen::Vector2d unknown_direction() {
    return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  }
};

/// The tail about the middle of `positions`, of the given degree or the largest below it that the
/// positions determine even with any one of them left out: collinear or few ones have no slope.
/// With the tool's direction where there is one of each position and they determine those terms,
/// too: it must turn by some ten degrees, and not with the position.
TailBasis tail_for(const Eigen::Matrix2Xd& positions, int degree = 1,
                   const Eigen::Matrix2Xd& directions = {});

/// The tail for other positions with the terms of `basis`, as far as they determine them.
TailBasis tail_like(const TailBasis& basis, const Eigen::Matrix2Xd& positions,
                    const Eigen::Matrix2Xd& directions);

}  // namespace planar
