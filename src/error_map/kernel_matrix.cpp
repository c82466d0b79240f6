#include "error_map/kernel_matrix.h"

namespace planar {

Eigen::MatrixXd squared_distances(const Eigen::Matrix2Xd& positions) {
  const Eigen::Index n = positions.cols();
  Eigen::MatrixXd distances2(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    distances2.col(j).tail(n - j) =
        (positions.rightCols(n - j).colwise() - positions.col(j)).colwise().squaredNorm();
  }
  return distances2;
}

void gaussian_kernel(const Eigen::MatrixXd& squared_distances, double width,
                     Eigen::MatrixXd& kernel) {
  const Eigen::Index n = squared_distances.cols();
  kernel.resize(n, n);
  const double rate = -0.5 / (width * width);
  for (Eigen::Index j = 0; j < n; ++j) {
    kernel.col(j).tail(n - j) = (squared_distances.col(j).tail(n - j).array() * rate).exp();
  }
}

Eigen::VectorXd gaussian_at(const Eigen::Matrix2Xd& centers, double width,
                            const Eigen::Vector2d& p) {
  const double rate = -0.5 / (width * width);
  return ((centers.colwise() - p).colwise().squaredNorm().array() * rate).exp();
}

}  // namespace planar
