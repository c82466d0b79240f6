#include "error_map/radial_kernel.h"

#include <cmath>

namespace planar {
namespace {

/// Twice what positions all over a disc, as wide as the kernel, need.
constexpr double kLevelOverFarthest = 4.0;

/// The kernel of squared distances, written to `values`.
template <typename Values, typename Distances>
void evaluate(const RadialKernel& kernel, const Distances& distances2, Values&& values) {
  const double scale = 1.0 / (kernel.width * kernel.width);
  switch (kernel.shape) {
    case KernelShape::kGaussian:
      values = (distances2 * (-0.5 * scale)).exp();
      return;
    case KernelShape::kMultiquadric: {
      const double rate = 1.0 / kernel.level();
      values = (1.0 + rate) - (1.0 + distances2 * scale).sqrt() * rate;
      return;
    }
  }
}

}  // namespace

double RadialKernel::level() const {
  return kLevelOverFarthest * std::hypot(1.0, span / width);
}

double span_of(const Eigen::Matrix2Xd& positions) {
  return (positions.rowwise().maxCoeff() - positions.rowwise().minCoeff()).norm();
}

Eigen::MatrixXd squared_distances(const Eigen::Matrix2Xd& positions) {
  const Eigen::Index n = positions.cols();
  Eigen::MatrixXd distances2(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    distances2.col(j).tail(n - j) =
        (positions.rightCols(n - j).colwise() - positions.col(j)).colwise().squaredNorm();
  }
  return distances2;
}

void kernel_matrix(const RadialKernel& kernel, const Eigen::MatrixXd& squared_distances,
                   Eigen::MatrixXd& matrix) {
  const Eigen::Index n = squared_distances.cols();
  matrix.resize(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    evaluate(kernel, squared_distances.col(j).tail(n - j).array(),
             matrix.col(j).tail(n - j).array());
  }
}

Eigen::VectorXd kernel_at(const RadialKernel& kernel, const Eigen::MatrixX2d& centers,
                          const Eigen::Vector2d& p) {
  Eigen::VectorXd values(centers.rows());
  evaluate(kernel,
           (centers.col(0).array() - p.x()).square() + (centers.col(1).array() - p.y()).square(),
           values.array());
  return values;
}

}  // namespace planar
