#pragma once

#include <Eigen/Core>

namespace planar {

/// The polynomial that a radial basis function map stands on, as a basis q(p) of scaled coordinates
/// (p - origin) / scale: degree 2 is [1, x, y, x^2, xy, y^2], degree 1 is [1, x, y], degree 0 is
/// [1], degree -1 is empty.
struct TailBasis {
  int degree{1};
  Eigen::Vector2d origin{0.0, 0.0};  ///< metres
  double scale{1.0};                 ///< metres

  Eigen::Index terms() const { return (degree + 1) * (degree + 2) / 2; }
  /// q(p), of `terms()` elements.
  Eigen::VectorXd at(const Eigen::Vector2d& p) const;
  /// q of each column of `positions`, one row each.
  Eigen::MatrixXd at_each(const Eigen::Matrix2Xd& positions) const;
};

/// The tail about the middle of `positions`, of the given degree or the largest below it that the
/// positions determine even with any one of them left out: collinear or few ones have no slope.
TailBasis tail_for(const Eigen::Matrix2Xd& positions, int degree = 1);

}  // namespace planar
