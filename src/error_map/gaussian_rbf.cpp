#include "error_map/gaussian_rbf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/units.h"
#include "error_map/kernel_matrix.h"

namespace planar {
namespace {

/// Below this a pivot of the kernel matrix is mostly rounding (200 unit terms of 2e-16 each).
constexpr double kSmallestPivotRatio = 1e-13;

Eigen::MatrixXd kernel_matrix(const Eigen::Matrix2Xd& centers, double width, double ridge) {
  Eigen::MatrixXd kernel;
  gaussian_kernel(squared_distances(centers), width, kernel);
  kernel.diagonal().array() += ridge;
  return kernel;
}

BorderedSystem solvable_system(const Eigen::Matrix2Xd& centers, const TailBasis& tail_basis,
                               double width, double ridge) {
  auto system =
      BorderedSystem::factorize(kernel_matrix(centers, width, ridge), tail_basis.at_each(centers));
  if (system && system->pivot_ratio() >= kSmallestPivotRatio) return *std::move(system);
  throw WorkError(fmt::format(
      "the kernel matrix of {} samples with a width of {:.4g} mm and a ridge of {:.3g} is too ill "
      "conditioned to be solved; use a smaller width, or let the map choose width and ridge",
      centers.cols(), width / kMillimetre, ridge));
}

}  // namespace

GaussianRbfMap::GaussianRbfMap(GaussianRbfParameters parameters)
    : parameters_(std::move(parameters)),
      system_(solvable_system(parameters_.centers, parameters_.tail_basis, parameters_.width,
                              parameters_.ridge)) {}

ErrorPrediction GaussianRbfMap::predict(const Eigen::Vector2d& p) const {
  const Eigen::VectorXd kernel = gaussian_at(parameters_.centers, parameters_.width, p);
  const Eigen::VectorXd q = parameters_.tail_basis.at(p);
  const double sigma = parameters_.signal_sigma * unit_sigma(kernel, q);
  return {parameters_.weights * kernel + parameters_.tail * q, sigma,
          sigma <= parameters_.sigma_limit && parameters_.region.contains(p)};
}

double GaussianRbfMap::unit_sigma(const Eigen::Vector2d& p) const {
  return unit_sigma(gaussian_at(parameters_.centers, parameters_.width, p),
                    parameters_.tail_basis.at(p));
}

double GaussianRbfMap::unit_sigma(const Eigen::VectorXd& kernel, const Eigen::VectorXd& q) const {
  return std::sqrt(std::max(0.0, 1.0 - system_.inverse_form(kernel, q)));
}

double GaussianRbfMap::noise_sigma() const {
  return std::sqrt(parameters_.ridge) * parameters_.signal_sigma;
}

GaussianRbfFit fit_gaussian_rbf(const Eigen::Matrix2Xd& positions, const Eigen::Matrix2Xd& errors,
                                const TailBasis& tail_basis, double width, double ridge) {
  const BorderedSystem system = solvable_system(positions, tail_basis, width, ridge);
  const BorderedSystem::Solution solution = system.solve(errors.transpose());
  GaussianRbfParameters parameters;
  parameters.centers = positions;
  parameters.weights = solution.weights.transpose();
  parameters.tail_basis = tail_basis;
  parameters.tail = solution.tail.transpose();
  parameters.width = width;
  parameters.ridge = ridge;
  parameters.region = region_around(positions);
  LeaveOneOut left_out = leave_one_out(system, parameters.weights);

  const auto freedom = static_cast<double>(2 * (positions.cols() - tail_basis.terms()));
  const double signal2 = errors.cwiseProduct(parameters.weights).sum() / freedom;
  parameters.signal_sigma = std::sqrt(std::max(0.0, signal2));
  const double loneliest2 = left_out.unit_sigmas.array().square().maxCoeff() - ridge;
  parameters.sigma_limit = parameters.signal_sigma * std::sqrt(std::max(0.0, loneliest2));
  return {GaussianRbfMap(std::move(parameters)), std::move(left_out)};
}

}  // namespace planar
