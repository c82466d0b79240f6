#include "planar_servo/error_map/fit/map_sites.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/error_map/maps/tail_basis.h"

namespace planar {
namespace {

/// Samples in one cell of a grid with this pitch count as one position. It is far below what vision
/// resolves, and centres that are closer would only worsen the condition of the equations.
constexpr double kSamePosition = 0.1 * kMicrometre;

constexpr std::size_t kFewestSites = 3;

void require_finite(const std::vector<ErrorSample>& samples) {
  Faults faults;
  for (const ErrorSample& sample : samples) {
    if (sample.p_vision.allFinite() && sample.error.allFinite() &&
        std::isfinite(sample.phi.value_or(0.0)))
      continue;
    faults.add(
        {fmt::format("pair {}: position, error or direction is not a finite number", sample.id),
         "remove the pair"});
  }
  faults.throw_if_any();
}

/// What samples of one site have in common: the word of their place, or else their position.
using SiteKey = std::tuple<std::string, double, double>;

SiteKey key_of(const ErrorSample& sample) {
  if (!sample.place.empty()) return {sample.place, 0.0, 0.0};
  const Eigen::Vector2d cell = (sample.p_vision / kSamePosition).array().round();
  return {"", cell.x(), cell.y()};
}

using Groups = std::vector<std::vector<std::size_t>>;

Groups group_by_site(const std::vector<ErrorSample>& samples, const std::vector<bool>& used) {
  Groups groups;
  std::map<SiteKey, std::size_t> group_of_key;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!used[i]) continue;
    const auto [found, is_new] = group_of_key.try_emplace(key_of(samples[i]), groups.size());
    if (is_new) groups.emplace_back();
    groups[found->second].push_back(i);
  }
  return groups;
}

void require_enough(const Groups& groups, const std::vector<ErrorSample>& samples) {
  if (groups.size() >= kFewestSites) return;
  throw InputError({fmt::format("{} pairs have {} distinct {}", samples.size(), groups.size(),
                                names_places(samples) ? "places" : "positions"),
                    fmt::format("a map needs at least {} distinct positions", kFewestSites)});
}

double stated_sigma_of(const std::vector<ErrorSample>& samples, const Groups& groups) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const auto& group : groups) {
    for (const std::size_t i : group) {
      if (!(samples[i].sigma > 0.0)) return 0.0;
      sum += samples[i].sigma * samples[i].sigma;
    }
    count += group.size();
  }
  return std::sqrt(sum / static_cast<double>(count));
}

/// Returns no columns where a sample has no direction.
Eigen::Matrix2Xd mean_directions(const std::vector<ErrorSample>& samples, const Groups& groups) {
  Eigen::Matrix2Xd means = Eigen::Matrix2Xd::Zero(2, static_cast<Eigen::Index>(groups.size()));
  for (std::size_t site = 0; site < groups.size(); ++site) {
    for (const std::size_t i : groups[site]) {
      if (!samples[i].phi) return {};
      const double phi = *samples[i].phi;
      means.col(static_cast<Eigen::Index>(site)) +=
          Eigen::Vector2d(std::cos(phi), std::sin(phi)) / static_cast<double>(groups[site].size());
    }
  }
  return means;
}

}  // namespace

MapSites MapSites::subset(const std::vector<Eigen::Index>& kept) const {
  MapSites sites{positions(Eigen::all, kept),
                 errors(Eigen::all, kept),
                 counts(kept),
                 scatter(kept),
                 {},
                 stated_sigma,
                 {},
                 place_share};
  if (has_directions()) sites.directions = directions(Eigen::all, kept);
  for (const Eigen::Index i : kept) sites.samples.push_back(samples[static_cast<std::size_t>(i)]);
  return sites;
}

MapSites MapSites::every(Eigen::Index stride) const {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < size(); i += stride) kept.push_back(i);
  return subset(kept);
}

Eigen::Vector2d MapSites::direction(Eigen::Index site) const {
  return has_directions() ? Eigen::Vector2d(directions.col(site)) : TailBasis::unknown_direction();
}

Eigen::VectorXd MapSites::weights_for(const Eigen::VectorXd& of_counts) const {
  return of_counts.array() / (1.0 - place_share + place_share * of_counts.array());
}

double MapSites::sample_rms(const Eigen::Matrix2Xd& means) const {
  const double sum = means.colwise().squaredNorm().dot(counts) + scatter.sum();
  return std::sqrt(sum / counts.sum());
}

bool names_places(const std::vector<ErrorSample>& samples) {
  return std::any_of(samples.begin(), samples.end(),
                     [](const ErrorSample& sample) { return !sample.place.empty(); });
}

MapSites merge_samples(const std::vector<ErrorSample>& samples) {
  return merge_samples(samples, std::vector<bool>(samples.size(), true));
}

MapSites merge_samples(const std::vector<ErrorSample>& samples, const std::vector<bool>& used) {
  require_finite(samples);
  MapSites sites;
  sites.samples = group_by_site(samples, used);
  require_enough(sites.samples, samples);
  sites.stated_sigma = stated_sigma_of(samples, sites.samples);
  sites.directions = mean_directions(samples, sites.samples);
  const auto count = static_cast<Eigen::Index>(sites.samples.size());
  sites.positions.setZero(2, count);
  sites.errors.setZero(2, count);
  sites.counts.setZero(count);
  sites.scatter.setZero(count);
  for (Eigen::Index site = 0; site < count; ++site) {
    const auto& merged = sites.samples[static_cast<std::size_t>(site)];
    sites.counts[site] = static_cast<double>(merged.size());
    for (const std::size_t i : merged) {
      sites.positions.col(site) += samples[i].p_vision / sites.counts[site];
      sites.errors.col(site) += samples[i].error / sites.counts[site];
    }
    for (const std::size_t i : merged)
      sites.scatter[site] += (samples[i].error - sites.errors.col(site)).squaredNorm();
  }
  return sites;
}

}  // namespace planar
