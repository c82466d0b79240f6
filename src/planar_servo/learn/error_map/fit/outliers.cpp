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

/// For each site the sites nearest to it, at most a dozen, without itself.
using Neighbours = std::vector<std::vector<Eigen::Index>>;

Neighbours nearest_sites(const MapSites& sites) {
  Neighbours neighbours;
  for (Eigen::Index i = 0; i < sites.size(); ++i) neighbours.push_back(nearest_to(i, sites));
  return neighbours;
}

/// Returns, in order, the sites whose error is roughly the median of their neighbours' errors. It
/// is a start for finer judgement that withstands up to a third of gross outliers.
std::vector<Eigen::Index> sites_like_their_neighbours(const MapSites& sites,
                                                      const Neighbours& neighbours) {
  std::vector<double> differences;
  for (Eigen::Index i = 0; i < sites.size(); ++i)
    differences.push_back(
        (sites.errors.col(i) - median_error(sites, neighbours[static_cast<std::size_t>(i)]))
            .norm());
  const double limit = kGross * median(differences);
  std::vector<Eigen::Index> alike;
  for (Eigen::Index i = 0; i < sites.size(); ++i)
    if (differences[static_cast<std::size_t>(i)] <= limit) alike.push_back(i);
  return alike;
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

std::vector<double> of_kept(const Eigen::ArrayXd& values, const std::vector<Eigen::Index>& kept,
                            const std::vector<Eigen::Index>& around) {
  std::vector<double> chosen;
  for (const Eigen::Index i : around)
    if (std::binary_search(kept.begin(), kept.end(), i)) chosen.push_back(values[i]);
  return chosen;
}

/// Searches for the sites that the others contradict, by maps of the first family.
class OutlierSearch {
 public:
  OutlierSearch(const MapSites& sites, TunedFamily tuned, std::vector<Eigen::Index> kept,
                Neighbours neighbours)
      : sites_(sites),
        neighbours_(std::move(neighbours)),
        kept_(std::move(kept)),
        tuned_(std::move(tuned)) {
    rejudge();
  }

  void drop_those_that_disagree() {
    for (int round = 1;; ++round) {
      const Eigen::ArrayXd limits = residual_limits(kNormal);
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
      const double dof = tail_dof(of_kept(judgement_.scaled(), kept_, kept_));
      const Eigen::ArrayXd limits = residual_limits(dof);
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

  /// Returns the largest residual with which each site is kept, if they follow Student's t.
  Eigen::ArrayXd residual_limits(double dof) const {
    const Eigen::ArrayXd scaled = judgement_.scaled();
    const double usual = median({scaled.begin(), scaled.end()}) / residual_length(0.5, dof);
    Eigen::ArrayXd scales(scaled.size());
    for (Eigen::Index i = 0; i < scaled.size(); ++i) {
      const auto around = of_kept(scaled, kept_, neighbours_[static_cast<std::size_t>(i)]);
      const double local = around.empty() ? 0.0 : quantile(around, kLocalShare);
      scales[i] = std::max(usual, local / residual_length(1.0 - kLocalShare, dof));
    }
    return (outlier_sigmas(scaled.size(), dof) * scales * judgement_.unit_sigmas)
        .max(kSmallestOutlier);
  }

  const MapSites& sites_;
  Neighbours neighbours_;
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

Eigen::Vector2d median_error(const MapSites& sites, const std::vector<Eigen::Index>& of) {
  std::vector<double> x, y;
  for (const Eigen::Index site : of) {
    x.push_back(sites.errors(0, site));
    y.push_back(sites.errors(1, site));
  }
  return {median(x), median(y)};
}

RobustFit fit_without_outliers(const MapSites& sites, const std::vector<RbfFamily>& families) {
  if (sites.size() < kFewestToJudge)
    return {fit_rbf(sites, best_of(tune(sites, families))), sites_without({}, sites.size()), {}};
  Neighbours neighbours = nearest_sites(sites);
  const std::vector<Eigen::Index> start = sites_like_their_neighbours(sites, neighbours);
  std::vector<TunedFamily> tuned = tune(sites.subset(start), families);
  OutlierSearch search(sites, tuned.front(), start, std::move(neighbours));
  search.drop_those_that_disagree();
  search.take_back_where_tails_are_long();
  const MapSites used = sites.subset(search.kept());
  tuned.front() = search.tuned();
  for (std::size_t i = 1; i < tuned.size() && search.kept() != start; ++i)
    tuned[i] = retune(used, tuned[i]);
  return {fit_rbf(used, best_of(tuned)), search.kept(), search.outliers()};
}

}  // namespace planar
