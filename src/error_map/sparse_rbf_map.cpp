#include "error_map/sparse_rbf_map.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/units.h"

namespace planar {
namespace {

/// Added to the diagonal of K; far above rounding and far below any kernel value that matters.
constexpr double kTrace = 1e-9;

RadialKernel gaussian(double width) {
  return {KernelShape::kGaussian, width, 0.0};
}

}  // namespace

Eigen::MatrixXd center_factor(const Eigen::Matrix2Xd& centers, double width) {
  Eigen::MatrixXd kernel;
  kernel_matrix(gaussian(width), squared_distances(centers), kernel);
  kernel.diagonal().array() += kTrace;
  const Eigen::LLT<Eigen::MatrixXd> cholesky(kernel);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixL();
  throw WorkError(fmt::format(
      "the kernel matrix of {} centres with a width of {:.4g} mm is too ill conditioned "
      "to be solved; use a smaller width",
      centers.cols(), width / kMillimetre));
}

SparseRbfMap::SparseRbfMap(SparseRbfParameters parameters)
    : parameters_(std::move(parameters)),
      centers_(parameters_.centers.transpose()),
      weights_(parameters_.weights.transpose()),
      kernel_factor_(center_factor(parameters_.centers, parameters_.width)) {}

Eigen::Vector2d SparseRbfMap::predict_error(const Eigen::Vector2d& p) const {
  const Eigen::VectorXd kernel = kernel_at(gaussian(parameters_.width), centers_, p);
  const Eigen::Vector2d sum(weights_.col(0).dot(kernel), weights_.col(1).dot(kernel));
  return sum + parameters_.tail * parameters_.tail_basis.at(p);
}

ErrorPrediction SparseRbfMap::predict(const Eigen::Vector2d& p) const {
  const Eigen::VectorXd kernel = kernel_at(gaussian(parameters_.width), centers_, p);
  const Eigen::VectorXd q = parameters_.tail_basis.at(p);
  Eigen::VectorXd basis(kernel.size() + q.size());
  basis << kernel_factor_.triangularView<Eigen::Lower>().solve(kernel), q;
  const double represented = basis.head(kernel.size()).squaredNorm();
  const double open = parameters_.factor.triangularView<Eigen::Lower>().solve(basis).squaredNorm();
  const double unit_variance = std::max(0.0, 1.0 - represented) + parameters_.ridge * open;
  const double sigma = parameters_.signal_sigma * std::sqrt(unit_variance);
  const Eigen::Vector2d sum(weights_.col(0).dot(kernel), weights_.col(1).dot(kernel));
  return {sum + parameters_.tail * q, sigma,
          sigma <= parameters_.sigma_limit && parameters_.region.contains(p)};
}

double SparseRbfMap::noise_sigma() const {
  return std::sqrt(parameters_.ridge) * parameters_.signal_sigma;
}

}  // namespace planar
