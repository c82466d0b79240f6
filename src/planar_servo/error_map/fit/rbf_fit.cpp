#include "planar_servo/error_map/fit/rbf_fit.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <memory>
#include <utility>

#include "planar_servo/error_map/maps/bordered_system.h"

namespace planar {
namespace {

bool is_clearly_better(const TunedKernel& other, const TunedKernel& first) {
  const Eigen::ArrayXd gains = first.squared_misses - other.squared_misses;
  return gains.sum() > standard_error_of_sum(gains);
}

TailBasis tail_of(const MapSites& sites, const RbfFamily& family) {
  if (!family.with_direction) return tail_for(sites.positions, family.tail_degree);
  return tail_for(sites.positions, family.tail_degree, sites.directions);
}

std::vector<TunedFamily> tune_each(const MapSites& sites, const std::vector<RbfFamily>& families) {
  const auto tune_one = [&](const RbfFamily& family) { return tune(sites, family); };
  std::vector<std::future<TunedFamily>> running;
  for (std::size_t i = 1; i < families.size(); ++i)
    running.push_back(std::async(std::launch::async, tune_one, families[i]));
  std::vector<TunedFamily> tuned{tune_one(families.front())};
  for (auto& other : running) tuned.push_back(other.get());
  return tuned;
}

}  // namespace

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

TunedFamily tune(const MapSites& sites, const RbfFamily& family) {
  TailBasis tail_basis = tail_of(sites, family);
  TunedKernel tuned = tune_rbf(sites, tail_basis, family.shape);
  return {family, tail_basis, std::move(tuned)};
}

std::vector<TunedFamily> tune(const MapSites& sites, const std::vector<RbfFamily>& families) {
  std::vector<TunedFamily> tuned = tune_each(sites, families);
  std::vector<RbfFamily> directed = families;
  for (RbfFamily& family : directed) family.with_direction = true;
  if (!tail_of(sites, directed.front()).with_direction) return tuned;
  std::vector<TunedFamily> directed_tuned = tune_each(sites, directed);
  const bool better = is_clearly_better(directed_tuned.front().tuned, tuned.front().tuned);
  return better ? directed_tuned : tuned;
}

TunedFamily retune(const MapSites& sites, const TunedFamily& before) {
  TailBasis tail_basis = tail_of(sites, before.family);
  TunedKernel tuned = retune_rbf(sites, tail_basis, before.tuned);
  return {before.family, tail_basis, std::move(tuned)};
}

RbfFit fit_rbf(const MapSites& sites, const TunedFamily& family) {
  return fit_rbf(sites, family.tail_basis, family.tuned.kernel, family.tuned.ridge);
}

RbfFit fit_hand_width(const MapSites& sites, double width) {
  TailBasis no_tail;
  no_tail.degree = -1;
  return fit_rbf(sites, no_tail, {KernelShape::kGaussian, width, 0.0}, 0.0);
}

const TunedFamily& best_of(const std::vector<TunedFamily>& families) {
  const TunedFamily* best = &families.front();
  for (const TunedFamily& other : families)
    if (other.tuned.loo_rms < best->tuned.loo_rms &&
        is_clearly_better(other.tuned, families.front().tuned))
      best = &other;
  return *best;
}

}  // namespace planar
