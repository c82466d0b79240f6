#include "error_map/best_rbf.h"

#include <utility>

namespace planar {
namespace {

bool is_clearly_better(const TunedKernel& other, const TunedKernel& first) {
  const Eigen::ArrayXd gains = first.squared_misses - other.squared_misses;
  return gains.sum() > standard_error_of_sum(gains);
}

}  // namespace

TunedFamily tune(const MapSites& sites, const RbfFamily& family) {
  TailBasis tail_basis = tail_for(sites.positions, family.tail_degree);
  TunedKernel tuned = tune_rbf(sites, tail_basis, family.shape);
  return {tail_basis, std::move(tuned)};
}

TunedFamily retune(const MapSites& sites, const RbfFamily& family, const TunedFamily& before) {
  TailBasis tail_basis = tail_for(sites.positions, family.tail_degree);
  TunedKernel tuned = retune_rbf(sites, tail_basis, before.tuned);
  return {tail_basis, std::move(tuned)};
}

RbfFit fit_rbf(const MapSites& sites, const TunedFamily& family) {
  return fit_rbf(sites, family.tail_basis, family.tuned.kernel, family.tuned.ridge);
}

RbfFit fit_hand_width(const MapSites& sites, double width) {
  TailBasis no_tail;
  no_tail.degree = -1;
  return fit_rbf(sites, no_tail, {KernelShape::kGaussian, width, 0.0}, 0.0);
}

TunedFamily best_family(const MapSites& sites, const TunedFamily& first,
                        const std::vector<RbfFamily>& others) {
  TunedFamily best = first;
  for (const RbfFamily& family : others) {
    TunedFamily other = tune(sites, family);
    if (other.tuned.loo_rms < best.tuned.loo_rms && is_clearly_better(other.tuned, first.tuned))
      best = std::move(other);
  }
  return best;
}

}  // namespace planar
