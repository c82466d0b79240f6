#pragma once

#include <Eigen/Core>

namespace planar {

/// The functions of which each component of a vision error field is made: Gaussians about centres
/// that fill a disc evenly, and the six terms of a quadratic in p / radius.
///
///     e(p) = sum_j w_j exp(-|p - c_j|^2 / (2 width^2)) + quadratic
struct FieldBasis {
  Eigen::Matrix2Xd centers;  ///< metres
  double width{0.1};         ///< metres
  double radius{1.0};        ///< metres

  Eigen::Index terms() const { return centers.cols() + kQuadratic; }
  Eigen::RowVectorXd at(const Eigen::Vector2d& p) const;
  /// Returns the first of these, without the quadratic.
  Eigen::RowVectorXd gaussians(const Eigen::Vector2d& p) const;
  /// Returns the inverse of the prior covariance of the Gaussians' weights, for unit variance.
  Eigen::MatrixXd kernel_matrix() const;

  static constexpr Eigen::Index kQuadratic = 6;
};

/// Returns a basis of this width for a field over a disc about the base's axis.
FieldBasis basis_over_disc(double radius, double width);

/// Returns a basis for a function of one number, which is x of the places, over a span of it. It
/// has this width, or a greater one where the span would take too many Gaussians.
FieldBasis basis_over_span(double first, double last, double width);

}  // namespace planar
