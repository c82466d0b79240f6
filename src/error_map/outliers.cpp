#include "error_map/outliers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/error.h"
#include "core/statistics.h"
#include "core/units.h"
#include "error_map/gross_outliers.h"
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

/// The first fits are bent by gross outliers and drop good sites, too; later on what is dropped
/// stays dropped, so that the rounds end.
constexpr int kRoundsOfTakingBack = 5;

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
  const TunedKernel tuned = tune_gaussian(sites, tail);
  return fit_gaussian_rbf(sites, tail, tuned.width, tuned.ridge);
}

Judgement judge(const MapSites& sites, const std::vector<Eigen::Index>& kept,
                const GaussianRbfFit& fit) {
  Judgement judgement{Eigen::ArrayXd::Zero(sites.size()), Eigen::ArrayXd::Zero(sites.size())};
  judgement.residuals(kept) = fit.left_out.residuals.colwise().norm().transpose().array();
  judgement.unit_sigmas(kept) = fit.left_out.unit_sigmas.array();
  const double ridge = fit.map.parameters().ridge;
  for (Eigen::Index i = 0; i < sites.size(); ++i) {
    if (std::binary_search(kept.begin(), kept.end(), i)) continue;
    const Eigen::Vector2d p = sites.positions.col(i);
    judgement.residuals[i] = (sites.errors.col(i) - fit.map.predict(p).error).norm();
    judgement.unit_sigmas[i] =
        std::hypot(fit.map.unit_sigma(p), std::sqrt(ridge / sites.counts[i]));
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

std::vector<Eigen::Index> sites_without(const std::map<Eigen::Index, Outlier>& dropped,
                                        Eigen::Index count) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < count; ++i) {
    if (dropped.count(i) == 0) kept.push_back(i);
  }
  return kept;
}

std::vector<Outlier> values_of(const std::map<Eigen::Index, Outlier>& dropped) {
  std::vector<Outlier> outliers;
  for (const auto& [site, outlier] : dropped) outliers.push_back(outlier);
  return outliers;
}

}  // namespace

RobustFit fit_without_outliers(const MapSites& sites) {
  if (sites.size() < kFewestToJudge) return {tuned_fit(sites), sites_without({}, sites.size()), {}};
  std::vector<Eigen::Index> kept = sites_like_their_neighbours(sites);
  std::map<Eigen::Index, Outlier> dropped;
  for (int round = 1;; ++round) {
    GaussianRbfFit fit = tuned_fit(sites.subset(kept));
    const Judgement judgement = judge(sites, kept, fit);
    const Eigen::ArrayXd limits = residual_limits(judgement);
    for (Eigen::Index i = 0; i < sites.size(); ++i) {
      if (judgement.residuals[i] > limits[i]) {
        dropped[i] = {i, judgement.residuals[i], limits[i]};
      } else if (round <= kRoundsOfTakingBack) {
        dropped.erase(i);
      }
    }
    require_few(dropped.size(), sites.size());
    std::vector<Eigen::Index> agreeing = sites_without(dropped, sites.size());
    if (agreeing == kept) return {std::move(fit), std::move(kept), values_of(dropped)};
    kept = std::move(agreeing);
  }
}

}  // namespace planar
