#include "planar_servo/error_map/maps/sparse_rbf_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "planar_servo/core/decompositions.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// A trace added to the diagonal of K: far above rounding, far below any kernel value that matters.
constexpr double kTrace = 1e-9;

RadialKernel gaussian(double width) {
  return {KernelShape::kGaussian, width, 0.0};
}

}  // namespace

Eigen::MatrixXd center_factor(const Eigen::Matrix2Xd& centers, double width) {
  Eigen::MatrixXd kernel;
  kernel_matrix(gaussian(width), squared_distances(centers), kernel);
  kernel.diagonal().array() += kTrace;
  if (auto factor = lower_factor(kernel)) return std::move(*factor);
  throw WorkError({fmt::format("the kernel matrix of {} centres with a width of {:.4g} mm is too "
                               "ill conditioned to be solved",
                               centers.cols(), mm(width)),
                   "use a smaller width"});
}

SparseRbfMap::SparseRbfMap(SparseRbfParameters parameters)
    : parameters_(std::move(parameters)),
      centers_(parameters_.centers.transpose()),
      weights_(parameters_.weights.transpose()),
      whitening_(inverse_of_lower(center_factor(parameters_.centers, parameters_.width))),
      open_(inverse_of_lower(parameters_.factor)) {}

Eigen::Vector2d SparseRbfMap::predict_error(const Eigen::Vector2d& p) const {
  const Eigen::VectorXd kernel = kernel_at(gaussian(parameters_.width), centers_, p);
  const Eigen::Vector2d sum(weights_.col(0).dot(kernel), weights_.col(1).dot(kernel));
  return sum + parameters_.tail * parameters_.tail_basis.at(p);
}

ErrorPrediction SparseRbfMap::predict(const Eigen::Vector2d& p) const {
  const Eigen::VectorXd kernel = kernel_at(gaussian(parameters_.width), centers_, p);
  const Eigen::VectorXd q = parameters_.tail_basis.at(p);
  const Eigen::VectorXd whitened = whitening_.triangularView<Eigen::Lower>() * kernel;
  Eigen::VectorXd basis(kernel.size() + q.size());
  basis << whitened, q;
  const Eigen::VectorXd open = open_.triangularView<Eigen::Lower>() * basis;
  const double unit_variance =
      std::max(0.0, 1.0 - whitened.squaredNorm()) + parameters_.ridge * open.squaredNorm();
  const double sigma = parameters_.signal_sigma * std::sqrt(unit_variance);
  const Eigen::Vector2d sum(weights_.col(0).dot(kernel), weights_.col(1).dot(kernel));
  return {sum + parameters_.tail * q, sigma,
          sigma <= parameters_.sigma_limit && parameters_.region.contains(p)};
}

double SparseRbfMap::noise_sigma() const {
  return std::sqrt(parameters_.ridge) * parameters_.signal_sigma;
}

}  // namespace planar
