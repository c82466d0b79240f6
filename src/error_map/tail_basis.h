#pragma once

#include <Eigen/Core>

namespace planar {

/// The polynomial that a radial basis function map stands on, as a basis q(p) of scaled coordinates
/// (p - origin) / scale: degree 1 is [1, x, y], degree 0 is [1], degree -1 is empty.
struct TailBasis {
  int degree{1};
  Eigen::Vector2d origin{0.0, 0.0};  ///< metres
  double scale{1.0};                 ///< metres

  Eigen::Index terms() const { return degree < 0 ? 0 : degree == 0 ? 1 : 3; }
  /// q(p), of `terms()` elements.
  Eigen::VectorXd at(const Eigen::Vector2d& p) const;
  /// q of each column of `positions`, one row each.
  Eigen::MatrixXd at_each(const Eigen::Matrix2Xd& positions) const;
};

/// The linear tail about the middle of `positions`, or only its constant where the positions do not
/// determine a slope, even with any one of them left out: collinear or too few.
TailBasis tail_for(const Eigen::Matrix2Xd& positions);

}  // namespace planar
