#include "planar_servo/error_map/maps/radial_kernel.h"

#include <cmath>

namespace planar {
namespace {

/// The level divided by the largest value of sqrt(1 + u^2). It is twice what positions all over a
/// disc, as wide as the kernel, need.
constexpr double kLevelOverFarthest = 4.0;

/// Replaces squared distances by the kernel there.
void evaluate(const RadialKernel& kernel, Eigen::Ref<Eigen::ArrayXd> values) {
  const double rate = 1.0 / (kernel.width * kernel.width);
  // Numbers that are not normal would slow down all sums.
  constexpr double kLeast = -708.0;
  if (kernel.shape == KernelShape::kGaussian)
    values =
        (-0.5 * rate * values).unaryExpr([](double x) { return x < kLeast ? 0.0 : std::exp(x); });
  else
    values = (1.0 + 1.0 / kernel.level()) - (1.0 + rate * values).sqrt() / kernel.level();
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
  for (Eigen::Index j = 0; j < n; ++j)
    distances2.col(j).tail(n - j) =
        (positions.rightCols(n - j).colwise() - positions.col(j)).colwise().squaredNorm();
  return distances2;
}

void kernel_matrix(const RadialKernel& kernel, const Eigen::MatrixXd& squared_distances,
                   Eigen::MatrixXd& matrix) {
  const Eigen::Index n = squared_distances.cols();
  matrix.resize(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    matrix.col(j).tail(n - j) = squared_distances.col(j).tail(n - j);
    evaluate(kernel, matrix.col(j).tail(n - j).array());
  }
}

Eigen::VectorXd kernel_at(const RadialKernel& kernel, const Eigen::MatrixX2d& centers,
                          const Eigen::Vector2d& p) {
  Eigen::ArrayXd values =
      (centers.col(0).array() - p.x()).square() + (centers.col(1).array() - p.y()).square();
  evaluate(kernel, values);
  return values;
}

}  // namespace planar
