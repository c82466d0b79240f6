#pragma once

#include <Eigen/Core>

namespace planar {

/// Positive definite functions of u = distance / width that are 1 at distance 0.
enum class KernelShape {
  kGaussian,      ///< exp(-u^2 / 2): one scale, infinitely smooth
  kMultiquadric,  ///< 1 - (sqrt(1 + u^2) - 1) / level: all scales from the width upwards
};

/// A kernel with its width. The multiquadric -sqrt(1 + u^2) alone is positive definite only for
/// weights that sum to 0, as a tail makes them. The level, a constant that does not change such
/// sums, makes it positive definite for all positions within `span` of each other.
struct RadialKernel {
  KernelShape shape{KernelShape::kGaussian};
  double width{0.0};  ///< metres
  double span{0.0};   ///< metres; only for the multiquadric

  double level() const;
};

/// Returns the diagonal of the positions' box, metres; one column per position.
double span_of(const Eigen::Matrix2Xd& positions);

/// Returns the squared distances between columns of `positions`; only the lower triangle is filled.
Eigen::MatrixXd squared_distances(const Eigen::Matrix2Xd& positions);

/// Writes the kernel of each element of the lower triangle into that of `matrix`.
void kernel_matrix(const RadialKernel& kernel, const Eigen::MatrixXd& squared_distances,
                   Eigen::MatrixXd& matrix);

/// Returns the kernel of the distance from p to each row of `centers`.
Eigen::VectorXd kernel_at(const RadialKernel& kernel, const Eigen::MatrixX2d& centers,
                          const Eigen::Vector2d& p);

}  // namespace planar
