#pragma once

#include <Eigen/Core>

namespace planar {

/// Positive definite functions of u = distance / width, 1 at distance 0.
enum class KernelShape {
  kGaussian,      ///< exp(-u^2 / 2): one scale, as smooth as can be
  kMultiquadric,  ///< 1 - (sqrt(1 + u^2) - 1) / level: scales from the width upwards
};

/// The multiquadric -sqrt(1 + u^2) is positive definite only on weights that sum to 0, to which a
/// tail holds them; the level, a constant that such weights do not feel, makes it so on all
/// positions within `span` of each other.
struct RadialKernel {
  KernelShape shape{KernelShape::kGaussian};
  double width{0.0};  ///< metres
  double span{0.0};   ///< metres; only the multiquadric's

  double level() const;
};

/// The largest extent of `positions` (one column each): the diagonal of their box, metres.
double span_of(const Eigen::Matrix2Xd& positions);

/// Squared distances between columns of `positions`; only the lower triangle is filled.
Eigen::MatrixXd squared_distances(const Eigen::Matrix2Xd& positions);

/// The kernel of each element of the lower triangle, into that of `matrix`.
void kernel_matrix(const RadialKernel& kernel, const Eigen::MatrixXd& squared_distances,
                   Eigen::MatrixXd& matrix);

/// The kernel of the distance from p to each row of `centers`.
Eigen::VectorXd kernel_at(const RadialKernel& kernel, const Eigen::MatrixX2d& centers,
                          const Eigen::Vector2d& p);

}  // namespace planar
