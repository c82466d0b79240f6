#include "error_map/outliers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/error.h"
#include "core/statistics.h"
#include "core/units.h"
#include "error_map/tuning.h"

namespace planar {
namespace {

/// Of a residual's length over its standard deviation per axis: one normal residual in 270,000.
constexpr double kOutlierSigmas = 5.0;

/// Nothing smaller is called an outlier, however well the rest agrees.
constexpr double kSmallestOutlier = 1.0 * kMicrometre;

constexpr double kLargestShare = 0.2;
/// With fewer sites none can be told from the rest.
constexpr Eigen::Index kFewestToJudge = 10;

constexpr int kMostRounds = 10;

/// Median length of a 2-D normal vector of unit standard deviation per axis.
const double kMedianLength = std::sqrt(2.0 * std::log(2.0));

/// Of each site, judged by the other kept sites: the residual's length and its standard deviation
/// over s_f.
struct Judgement {
  Eigen::ArrayXd residuals;
  Eigen::ArrayXd unit_sigmas;
};

GaussianRbfFit tuned_fit(const MapSites& sites) {
  const TailBasis tail = tail_for(sites.positions);
  const TunedKernel tuned = tune_gaussian(sites.positions, sites.errors, tail);
  return fit_gaussian_rbf(sites.positions, sites.errors, tail, tuned.width, tuned.ridge);
}

Judgement judge(const MapSites& sites, const std::vector<Eigen::Index>& kept,
                const GaussianRbfFit& fit) {
  Judgement judgement{Eigen::ArrayXd::Zero(sites.size()), Eigen::ArrayXd::Zero(sites.size())};
  judgement.residuals(kept) = fit.left_out.residuals.colwise().norm().transpose().array();
  judgement.unit_sigmas(kept) = fit.left_out.unit_sigmas.array();
  for (Eigen::Index i = 0; i < sites.size(); ++i) {
    if (std::binary_search(kept.begin(), kept.end(), i)) continue;
    const Eigen::Vector2d p = sites.positions.col(i);
    judgement.residuals[i] = (sites.errors.col(i) - fit.map.predict(p).error).norm();
    judgement.unit_sigmas[i] =
        std::hypot(fit.map.unit_sigma(p), std::sqrt(fit.map.parameters().ridge));
  }
  return judgement;
}

/// The largest residual that is kept, per site.
Eigen::ArrayXd residual_limits(const Judgement& judgement) {
  const Eigen::ArrayXd scaled = judgement.residuals / judgement.unit_sigmas;
  const double signal = median({scaled.begin(), scaled.end()}) / kMedianLength;
  return (kOutlierSigmas * signal * judgement.unit_sigmas).max(kSmallestOutlier);
}

void require_few(std::size_t dropped, Eigen::Index sites) {
  if (static_cast<double>(dropped) <= kLargestShare * static_cast<double>(sites)) return;
  throw InputError(fmt::format(
      "{} of {} pairs disagree with the others, but at most {:.0f} % may; are the positions of "
      "vision and tracker paired rightly?",
      dropped, sites, 100.0 * kLargestShare));
}

std::vector<Eigen::Index> agreeing_sites(const Judgement& judgement, const Eigen::ArrayXd& limits) {
  std::vector<Eigen::Index> agreeing;
  for (Eigen::Index i = 0; i < limits.size(); ++i) {
    if (judgement.residuals[i] <= limits[i]) agreeing.push_back(i);
  }
  return agreeing;
}

std::vector<Outlier> all_but(const std::vector<Eigen::Index>& kept, const Judgement& judgement,
                             const Eigen::ArrayXd& limits) {
  std::vector<Outlier> outliers;
  for (Eigen::Index i = 0; i < limits.size(); ++i) {
    if (std::binary_search(kept.begin(), kept.end(), i)) continue;
    outliers.push_back({i, judgement.residuals[i], limits[i]});
  }
  return outliers;
}

}  // namespace

RobustFit fit_without_outliers(const MapSites& sites) {
  std::vector<Eigen::Index> kept(static_cast<std::size_t>(sites.size()));
  std::iota(kept.begin(), kept.end(), 0);
  for (int round = 1;; ++round) {
    GaussianRbfFit fit = tuned_fit(sites.subset(kept));
    if (sites.size() < kFewestToJudge) return {std::move(fit), std::move(kept), {}};
    const Judgement judgement = judge(sites, kept, fit);
    const Eigen::ArrayXd limits = residual_limits(judgement);
    std::vector<Eigen::Index> agreeing = agreeing_sites(judgement, limits);
    require_few(static_cast<std::size_t>(sites.size()) - agreeing.size(), sites.size());
    if (agreeing == kept || round == kMostRounds) {
      std::vector<Outlier> outliers = all_but(kept, judgement, limits);
      return {std::move(fit), std::move(kept), std::move(outliers)};
    }
    kept = std::move(agreeing);
  }
}

}  // namespace planar
