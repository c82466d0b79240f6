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
    judgement.residuals[i] = (sites.errors.col(i) - fit.map.predict_error(p)).norm();
    judgement.unit_sigmas[i] =
        std::hypot(fit.map.unit_sigma(p), std::sqrt(ridge / sites.counts[i]));
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

/// The choice among the families for the kept sites.
RobustFit chosen(const MapSites& sites, std::vector<Eigen::Index> kept,
                 const std::vector<RbfFamily>& families, const TunedFamily& first,
                 std::vector<Outlier> outliers) {
  const MapSites used = sites.subset(kept);
  const TunedFamily best = best_family(used, first, {families.begin() + 1, families.end()});
  return {fit_rbf(used, best), std::move(kept), std::move(outliers)};
}

}  // namespace

RobustFit fit_without_outliers(const MapSites& sites, const std::vector<RbfFamily>& families) {
  const RbfFamily& first = families.front();
  if (sites.size() < kFewestToJudge)
    return chosen(sites, sites_without({}, sites.size()), families, tune(sites, first), {});
  const Neighbours neighbours = nearest_sites(sites);
  std::vector<Eigen::Index> kept = sites_like_their_neighbours(sites, neighbours);
  TunedFamily tuned = tune(sites.subset(kept), first);
  Outliers dropped;
  for (int round = 1;; ++round) {
    const Judgement judgement = judge(sites, kept, fit_rbf(sites.subset(kept), tuned));
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
    if (agreeing == kept)
      return chosen(sites, std::move(kept), families, tuned, values_of(dropped));
    kept = std::move(agreeing);
    tuned = retune(sites.subset(kept), first, tuned);
  }
}

}  // namespace planar
