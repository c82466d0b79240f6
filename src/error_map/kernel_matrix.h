#pragma once

#include <Eigen/Core>

namespace planar {

/// Squared distances between columns of `positions`; only the lower triangle is filled.
Eigen::MatrixXd squared_distances(const Eigen::Matrix2Xd& positions);

/// exp(-d^2 / (2 width^2)) of each element of the lower triangle, into that of `kernel`.
void gaussian_kernel(const Eigen::MatrixXd& squared_distances, double width,
                     Eigen::MatrixXd& kernel);

/// Gaussian of the distance from p to each column of `centers`.
Eigen::VectorXd gaussian_at(const Eigen::Matrix2Xd& centers, double width,
                            const Eigen::Vector2d& p);

}  // namespace planar
