#include "planar_servo/learn/error_map/fit/outliers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/learn/error_map/error_map.h"

namespace planar {
namespace {

constexpr double kFalseAlarms = 0.05;
constexpr Eigen::Index kNeighbours = 12;

/// The limit of a difference over the median; wide, because the field differs over this distance.
constexpr double kGross = 10.0;

/// The quantile of the residuals around a site by which it is judged.
constexpr double kLocalShare = 0.9;

std::vector<Eigen::Index> nearest_to(Eigen::Index i, const MapSites& sites) {
  const Eigen::VectorXd distance2 =
      (sites.positions.colwise() - sites.positions.col(i)).colwise().squaredNorm();
  std::vector<Eigen::Index> order(static_cast<std::size_t>(sites.size()));
  std::iota(order.begin(), order.end(), 0);
  std::swap(order.front(), order[static_cast<std::size_t>(i)]);
  const auto last = order.begin() + std::min(kNeighbours, sites.size() - 1);
  std::nth_element(order.begin() + 1, last, order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return distance2[a] < distance2[b]; });
  return {order.begin() + 1, last + 1};
}

/// Has each site judged by those nearest to it, at most a dozen, without itself.
Neighbourhoods nearest_sites(const MapSites& sites) {
  Neighbourhoods near;
  for (Eigen::Index i = 0; i < sites.size(); ++i) {
    near.of_site.push_back(near.groups.size());
    near.groups.push_back(nearest_to(i, sites));
  }
  return near;
}

Eigen::Vector2d median_error(const MapSites& sites, const std::vector<Eigen::Index>& of) {
  const auto median_of = [&](Eigen::Index axis) {
    const Eigen::VectorXd values = sites.errors(axis, of).transpose();
    return median({values.begin(), values.end()});
  };
  return {median_of(0), median_of(1)};
}

/// With fewer sites an outlier cannot be told from the rest.
constexpr Eigen::Index kFewestToJudge = 10;

/// The length of each site's residual without itself, and its standard deviation divided by s_f.
struct Judgement {
  Eigen::ArrayXd residuals, unit_sigmas;

  Eigen::ArrayXd scaled() const { return residuals / unit_sigmas; }
};

Judgement judge(const MapSites& sites, const std::vector<Eigen::Index>& kept, const RbfFit& fit) {
  Judgement judgement{Eigen::ArrayXd::Zero(sites.size()), Eigen::ArrayXd::Zero(sites.size())};
  judgement.residuals(kept) = fit.left_out.residuals.colwise().norm().transpose().array();
  judgement.unit_sigmas(kept) = fit.left_out.unit_sigmas.array();
  const Eigen::ArrayXd noise2 = fit.map.parameters().ridge / sites.weights().array();
  for (Eigen::Index i = 0; i < sites.size(); ++i) {
    if (std::binary_search(kept.begin(), kept.end(), i)) continue;
    const Eigen::Vector2d p = sites.positions.col(i);
    judgement.residuals[i] =
        (sites.errors.col(i) - fit.map.predict_error(p, sites.direction(i))).norm();
    judgement.unit_sigmas[i] =
        std::hypot(fit.map.unit_sigma(p, sites.direction(i)), std::sqrt(noise2[i]));
  }
  return judgement;
}

/// Searches for the sites that the others contradict, by maps of the first family.
class OutlierSearch {
 public:
  OutlierSearch(const MapSites& sites, TunedFamily tuned, std::vector<Eigen::Index> kept,
                Neighbourhoods near)
      : sites_(sites), near_(std::move(near)), kept_(std::move(kept)), tuned_(std::move(tuned)) {
    rejudge();
  }

  void drop_those_that_disagree() {
    for (int round = 1;; ++round) {
      const Eigen::ArrayXd limits = limits_for(kNormal);
      for (Eigen::Index i = 0; i < sites_.size(); ++i) {
        if (judgement_.residuals[i] > limits[i])
          dropped_[i] = {i, judgement_.residuals[i], limits[i]};
        else if (round <= kRoundsOfTakingBack)
          dropped_.erase(i);
      }
      require_few(dropped_, sites_.size());
      if (!follow_dropped()) return;
    }
  }

  /// Judges the dropped sites again with the tails that the kept residuals show.
  void take_back_where_tails_are_long() {
    while (!dropped_.empty()) {
      const Eigen::ArrayXd kept = judgement_.scaled()(kept_);
      const double dof = tail_dof({kept.begin(), kept.end()});
      const Eigen::ArrayXd limits = limits_for(dof);
      for (auto at = dropped_.begin(); at != dropped_.end();) {
        Outlier& outlier = at->second;
        outlier = {at->first, judgement_.residuals[at->first], limits[at->first]};
        at = outlier.residual > outlier.limit ? std::next(at) : dropped_.erase(at);
      }
      if (!follow_dropped()) return;
    }
  }

  const std::vector<Eigen::Index>& kept() const { return kept_; }
  const TunedFamily& tuned() const { return tuned_; }
  std::vector<Outlier> outliers() const { return values_of(dropped_); }

 private:
  void rejudge() { judgement_ = judge(sites_, kept_, fit_rbf(sites_.subset(kept_), tuned_)); }

  /// Fits anew without the dropped sites; returns whether other sites are kept than before.
  bool follow_dropped() {
    std::vector<Eigen::Index> kept = sites_without(dropped_, sites_.size());
    if (kept == kept_) return false;
    kept_ = std::move(kept);
    tuned_ = retune(sites_.subset(kept_), tuned_);
    rejudge();
    return true;
  }

  Eigen::ArrayXd limits_for(double dof) const {
    return residual_limits(judgement_.residuals, judgement_.unit_sigmas, kept_, near_, dof);
  }

  const MapSites& sites_;
  Neighbourhoods near_;
  std::vector<Eigen::Index> kept_;  ///< in order
  TunedFamily tuned_;
  Judgement judgement_;
  Outliers dropped_;
};

}  // namespace

double residual_length(double share, double dof) {
  if (dof == kNormal) return std::sqrt(-2.0 * std::log(share));
  return std::sqrt(dof * (std::pow(share, -2.0 / dof) - 1.0));
}

double tail_dof(const std::vector<double>& lengths) {
  // With a = 2^(2 / dof) the squared ratio of the two lengths is (a^3 - 1) / (a - 1) = a^2 + a + 1.
  const double ratio = quantile(lengths, 1.0 - 0.125) / median(lengths);
  const double a = 0.5 * (std::sqrt(4.0 * ratio * ratio - 3.0) - 1.0);
  return a > 1.0 ? 2.0 / std::log2(a) : kNormal;
}

double outlier_sigmas(Eigen::Index sites, double dof) {
  return residual_length(kFalseAlarms / static_cast<double>(sites), dof);
}

void require_few(const Outliers& dropped, Eigen::Index sites) {
  if (static_cast<double>(dropped.size()) <= kMostContradicting * static_cast<double>(sites))
    return;
  throw InputError({fmt::format("{} of {} pairs disagree with the others, but at most {:.0f} % may",
                                dropped.size(), sites, 100.0 * kMostContradicting),
                    "are the positions of vision and tracker paired rightly?", "",
                    Cause::kContradiction});
}

std::vector<Eigen::Index> sites_without(const Outliers& dropped, Eigen::Index count) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < count; ++i)
    if (dropped.count(i) == 0) kept.push_back(i);
  return kept;
}

std::vector<Outlier> values_of(const Outliers& dropped) {
  std::vector<Outlier> outliers;
  for (const auto& [site, outlier] : dropped) outliers.push_back(outlier);
  return outliers;
}

Outliers gross_outliers(const MapSites& sites, const Neighbourhoods& near) {
  std::vector<Eigen::Vector2d> middles;
  for (const auto& group : near.groups)
    middles.push_back(group.empty() ? Eigen::Vector2d::Zero() : median_error(sites, group));
  std::vector<double> differences;
  for (std::size_t i = 0; i < near.of_site.size(); ++i)
    differences.push_back(
        (sites.errors.col(static_cast<Eigen::Index>(i)) - middles[near.of_site[i]]).norm());
  const double limit = kGross * median(differences);
  Outliers gross;
  for (Eigen::Index i = 0; limit > 0.0 && i < sites.size(); ++i)
    if (const double off = differences[static_cast<std::size_t>(i)]; off > limit)
      gross[i] = {i, off, limit};
  return gross;
}

Eigen::ArrayXd residual_limits(const Eigen::ArrayXd& residuals, const Eigen::ArrayXd& unit_sigmas,
                               const std::vector<Eigen::Index>& kept, const Neighbourhoods& near,
                               double dof) {
  const Eigen::ArrayXd scaled = residuals / unit_sigmas;
  Eigen::Array<bool, Eigen::Dynamic, 1> used =
      Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(scaled.size(), false);
  used(kept).setConstant(true);
  const double usual = median({scaled.begin(), scaled.end()}) / residual_length(0.5, dof);
  std::vector<double> scales;
  for (const auto& group : near.groups) {
    std::vector<double> around;
    for (const Eigen::Index i : group)
      if (used[i]) around.push_back(scaled[i]);
    const double local = around.empty() ? 0.0 : quantile(around, kLocalShare);
    scales.push_back(std::max(usual, local / residual_length(1.0 - kLocalShare, dof)));
  }
  Eigen::ArrayXd limits = outlier_sigmas(scaled.size(), dof) * unit_sigmas;
  for (Eigen::Index i = 0; i < limits.size(); ++i)
    limits[i] *= scales[near.of_site[static_cast<std::size_t>(i)]];
  return limits.max(kSmallestOutlier);
}

RobustFit fit_without_outliers(const MapSites& sites, const std::vector<RbfFamily>& families) {
  if (sites.size() < kFewestToJudge)
    return {fit_rbf(sites, best_of(tune(sites, families))), sites_without({}, sites.size()), {}};
  Neighbourhoods near = nearest_sites(sites);
  const std::vector<Eigen::Index> start = sites_without(gross_outliers(sites, near), sites.size());
  std::vector<TunedFamily> tuned = tune(sites.subset(start), families);
  OutlierSearch search(sites, tuned.front(), start, std::move(near));
  search.drop_those_that_disagree();
  search.take_back_where_tails_are_long();
  const MapSites used = sites.subset(search.kept());
  tuned.front() = search.tuned();
  for (std::size_t i = 1; i < tuned.size() && search.kept() != start; ++i)
    tuned[i] = retune(used, tuned[i]);
  return {fit_rbf(used, best_of(tuned)), search.kept(), search.outliers()};
}

}  // namespace planar
