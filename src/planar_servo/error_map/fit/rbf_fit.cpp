#include "planar_servo/error_map/fit/rbf_fit.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "planar_servo/error_map/maps/bordered_system.h"

namespace planar {

LeaveOneOut leave_one_out(const BorderedSystem& system, const Eigen::Matrix2Xd& weights) {
  const Eigen::ArrayXd diagonal = system.inverse_diagonal();
  return {(weights.array().rowwise() / diagonal.transpose()).matrix(), diagonal.rsqrt()};
}

double standard_error_of_sum(const Eigen::ArrayXd& draws) {
  const auto n = static_cast<double>(draws.size());
  return std::sqrt((draws - draws.mean()).square().sum() * n / (n - 1.0));
}

double signal_variance(const MapSites& sites, const Eigen::Matrix2Xd& weights, Eigen::Index terms,
                       double ridge) {
  const double signal = sites.errors.cwiseProduct(weights).sum();
  if (sites.place_share > 0.0)
    return std::max(0.0, signal / (2.0 * static_cast<double>(sites.size() - terms)));
  const double freedom = sites.counts.sum() - static_cast<double>(terms);
  const double scatter = ridge > 0.0 ? sites.scatter.sum() / ridge : 0.0;
  return std::max(0.0, (signal + scatter) / (2.0 * freedom));
}

RbfFit fit_rbf(const MapSites& sites, const TailBasis& tail_basis, const RadialKernel& kernel,
               double ridge) {
  RbfParameters parameters;
  parameters.centers = sites.positions;
  parameters.counts = sites.weights();
  parameters.tail_basis = tail_basis;
  if (tail_basis.with_direction) parameters.directions = sites.directions;
  parameters.kernel = kernel;
  parameters.ridge = ridge;
  parameters.region = region_around(sites.positions);
  std::shared_ptr<const BorderedSystem> equations = map_equations(parameters);
  const BorderedSystem::Solution solution = equations->solve(sites.errors.transpose());
  parameters.weights = solution.weights.transpose();
  parameters.tail = solution.tail.transpose();
  LeaveOneOut left_out = leave_one_out(*equations, parameters.weights);

  const Eigen::ArrayXd site_noise2 = ridge / parameters.counts.array();
  const double loneliest2 = (left_out.unit_sigmas.array().square() - site_noise2).maxCoeff();
  parameters.signal_sigma =
      std::sqrt(signal_variance(sites, parameters.weights, tail_basis.terms(), ridge));
  parameters.sigma_limit = parameters.signal_sigma * std::sqrt(std::max(0.0, loneliest2));
  return {RbfMap(std::move(parameters), std::move(equations)), std::move(left_out)};
}

}  // namespace planar
