#include "planar_servo/error_map/fit/rbf_families.h"

#include <future>
#include <utility>

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
