#include "error_map/outliers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/statistics.h"
#include "error_map/gross_outliers.h"

namespace planar {
namespace {

/// With fewer sites none can be told from the rest.
constexpr Eigen::Index kFewestToJudge = 10;

/// Of each site, judged by the other kept sites: the residual's length and its standard deviation
/// over s_f.
struct Judgement {
  Eigen::ArrayXd residuals;
  Eigen::ArrayXd unit_sigmas;
};

Judgement judge(const MapSites& sites, const std::vector<Eigen::Index>& kept, const RbfFit& fit) {
  Judgement judgement{Eigen::ArrayXd::Zero(sites.size()), Eigen::ArrayXd::Zero(sites.size())};
  judgement.residuals(kept) = fit.left_out.residuals.colwise().norm().transpose().array();
  judgement.unit_sigmas(kept) = fit.left_out.unit_sigmas.array();
  const double ridge = fit.map.parameters().ridge;
  for (Eigen::Index i = 0; i < sites.size(); ++i) {
    if (std::binary_search(kept.begin(), kept.end(), i)) continue;
    const Eigen::Vector2d p = sites.positions.col(i);
    judgement.residuals[i] =
        (sites.errors.col(i) - fit.map.predict_error(p, sites.direction(i))).norm();
    judgement.unit_sigmas[i] =
        std::hypot(fit.map.unit_sigma(p, sites.direction(i)), std::sqrt(ridge / sites.counts[i]));
  }
  return judgement;
}

/// What kLocalShare of the kept sites around have a smaller scaled residual than.
double local_quantile(const Eigen::ArrayXd& scaled, const std::vector<Eigen::Index>& kept,
                      const std::vector<Eigen::Index>& around) {
  std::vector<double> values;
  for (const Eigen::Index i : around)
    if (std::binary_search(kept.begin(), kept.end(), i)) values.push_back(scaled[i]);
  return values.empty() ? 0.0 : quantile(values, kLocalShare);
}

/// The largest residual that is kept, per site.
Eigen::ArrayXd residual_limits(const Judgement& judgement, const std::vector<Eigen::Index>& kept,
                               const Neighbours& neighbours) {
  const Eigen::ArrayXd scaled = judgement.residuals / judgement.unit_sigmas;
  const double sigmas = outlier_sigmas(scaled.size());
  const double usual = median({scaled.begin(), scaled.end()}) / normal_length(0.5);
  Eigen::ArrayXd scales(scaled.size());
  for (Eigen::Index i = 0; i < scaled.size(); ++i) {
    const double local = local_quantile(scaled, kept, neighbours[static_cast<std::size_t>(i)]);
    scales[i] = std::max(usual, local / normal_length(1.0 - kLocalShare));
  }
  return (sigmas * scales * judgement.unit_sigmas).max(kSmallestOutlier);
}

}  // namespace

RobustFit fit_without_outliers(const MapSites& sites, const std::vector<RbfFamily>& families) {
  if (sites.size() < kFewestToJudge)
    return {fit_rbf(sites, best_of(tune(sites, families))), sites_without({}, sites.size()), {}};
  const Neighbours neighbours = nearest_sites(sites);
  std::vector<Eigen::Index> kept = sites_like_their_neighbours(sites, neighbours);
  const std::vector<Eigen::Index> start = kept;
  std::vector<TunedFamily> tuned = tune(sites.subset(kept), families);
  Outliers dropped;
  for (int round = 1;; ++round) {
    const MapSites used = sites.subset(kept);
    const Judgement judgement = judge(sites, kept, fit_rbf(used, tuned.front()));
    const Eigen::ArrayXd limits = residual_limits(judgement, kept, neighbours);
    for (Eigen::Index i = 0; i < sites.size(); ++i) {
      if (judgement.residuals[i] > limits[i]) {
        dropped[i] = {i, judgement.residuals[i], limits[i]};
      } else if (round <= kRoundsOfTakingBack) {
        dropped.erase(i);
      }
    }
    require_few(dropped, sites.size());
    std::vector<Eigen::Index> agreeing = sites_without(dropped, sites.size());
    if (agreeing == kept) {
      for (std::size_t i = 1; i < tuned.size() && kept != start; ++i)
        tuned[i] = retune(used, tuned[i]);
      return {fit_rbf(used, best_of(tuned)), std::move(kept), values_of(dropped)};
    }
    kept = std::move(agreeing);
    tuned.front() = retune(sites.subset(kept), tuned.front());
  }
}

}  // namespace planar
