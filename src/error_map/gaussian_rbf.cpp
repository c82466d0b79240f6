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

Eigen::MatrixXd kernel_matrix(const GaussianRbfParameters& parameters) {
  Eigen::MatrixXd kernel;
  gaussian_kernel(squared_distances(parameters.centers), parameters.width, kernel);
  kernel.diagonal().array() += parameters.ridge / parameters.counts.array();
  return kernel;
}

BorderedSystem solvable_system(const GaussianRbfParameters& parameters) {
  auto system = BorderedSystem::factorize(kernel_matrix(parameters),
                                          parameters.tail_basis.at_each(parameters.centers));
  if (system && system->pivot_ratio() >= kSmallestPivotRatio) return *std::move(system);
  throw WorkError(fmt::format(
      "the kernel matrix of {} samples with a width of {:.4g} mm and a ridge of {:.3g} is too ill "
      "conditioned to be solved; use a smaller width, or let the map choose width and ridge",
      parameters.centers.cols(), parameters.width / kMillimetre, parameters.ridge));
}

/// s_f^2 = E^T w / (N - m) per axis, over all samples: those averaged at a site scatter about it
/// with variance ridge s_f^2.
double signal_variance(const MapSites& sites, const GaussianRbfParameters& parameters) {
  const double freedom = sites.counts.sum() - static_cast<double>(parameters.tail_basis.terms());
  const double scatter = parameters.ridge > 0.0 ? sites.scatter.sum() / parameters.ridge : 0.0;
  const double sum = sites.errors.cwiseProduct(parameters.weights).sum() + scatter;
  return std::max(0.0, sum / (2.0 * freedom));
}

}  // namespace

GaussianRbfMap::GaussianRbfMap(GaussianRbfParameters parameters)
    : parameters_(std::move(parameters)), system_(solvable_system(parameters_)) {}

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

GaussianRbfFit fit_gaussian_rbf(const MapSites& sites, const TailBasis& tail_basis, double width,
                                double ridge) {
  GaussianRbfParameters parameters;
  parameters.centers = sites.positions;
  parameters.counts = sites.counts;
  parameters.tail_basis = tail_basis;
  parameters.width = width;
  parameters.ridge = ridge;
  parameters.region = region_around(sites.positions);
  const BorderedSystem system = solvable_system(parameters);
  const BorderedSystem::Solution solution = system.solve(sites.errors.transpose());
  parameters.weights = solution.weights.transpose();
  parameters.tail = solution.tail.transpose();
  LeaveOneOut left_out = leave_one_out(system, parameters.weights);

  const Eigen::ArrayXd site_noise2 = ridge / sites.counts.array();
  const double loneliest2 = (left_out.unit_sigmas.array().square() - site_noise2).maxCoeff();
  parameters.signal_sigma = std::sqrt(signal_variance(sites, parameters));
  parameters.sigma_limit = parameters.signal_sigma * std::sqrt(std::max(0.0, loneliest2));
  return {GaussianRbfMap(std::move(parameters)), std::move(left_out)};
}

}  // namespace planar
