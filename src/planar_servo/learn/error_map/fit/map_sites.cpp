#include "planar_servo/learn/error_map/fit/map_sites.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/learn/error_map/maps/rbf_basis.h"

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

/// The key of the samples of one site: the name of their place, or else their position.
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
                    fmt::format("a map needs at least {} distinct positions", kFewestSites), "",
                    Cause::kInsufficient});
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

/// The tree takes time with the square of the positions.
constexpr Eigen::Index kMostSearched = 5000;

/// At least this share of the tree's branches must lie within places, and there must be so many
/// places; otherwise a few neighbours that are close by chance would count as places.
constexpr double kLeastWithin = 0.2;
constexpr std::size_t kFewestPlaces = 10;

/// So many times as long are branches between places as within, but for a share: some are close.
constexpr double kLeastRatio = 2.0;
constexpr double kOverlap = 0.05;

/// Joins a site to the part of the tree that was there before.
struct Branch {
  Eigen::Index site{0}, parent{0};
  double length{0.0};  ///< metres
};

/// Returns the shortest tree from the first position [Prim 1957], in the order of its growth.
std::vector<Branch> shortest_tree(const Eigen::Matrix2Xd& positions) {
  std::vector<Branch> open;
  for (Eigen::Index i = 1; i < positions.cols(); ++i)
    open.push_back({i, 0, std::numeric_limits<double>::infinity()});
  std::vector<Branch> tree;
  for (Eigen::Index last = 0; !open.empty(); last = tree.back().site) {
    for (Branch& branch : open) {
      const double length = (positions.col(branch.site) - positions.col(last)).norm();
      if (length < branch.length) branch = {branch.site, last, length};
    }
    const auto nearest =
        std::min_element(open.begin(), open.end(),
                         [](const Branch& a, const Branch& b) { return a.length < b.length; });
    tree.push_back(*nearest);
    *nearest = open.back();
    open.pop_back();
  }
  return tree;
}

/// The lengths on both sides of the widest gap between those within places and between them.
struct LengthGap {
  double within{0.0}, between{0.0};
  double ratio() const { return between / within; }
};

std::optional<LengthGap> widest_gap(const std::vector<Branch>& tree) {
  std::vector<double> lengths;
  lengths.reserve(tree.size());
  for (const Branch& branch : tree) lengths.push_back(branch.length);
  std::sort(lengths.begin(), lengths.end());
  const auto count = static_cast<double>(lengths.size());
  const auto overlap = static_cast<std::size_t>(std::ceil(kOverlap * count));
  std::optional<LengthGap> widest;
  for (auto i = static_cast<std::size_t>(kLeastWithin * count); i + overlap < lengths.size(); ++i) {
    const LengthGap gap{lengths[i], lengths[i + overlap]};
    if (gap.ratio() >= (widest ? widest->ratio() : kLeastRatio)) widest = gap;
  }
  return widest;
}

/// Returns the sites that are joined by branches of at most this length.
std::vector<std::vector<Eigen::Index>> joined(const std::vector<Branch>& tree, double longest) {
  std::vector<std::vector<Eigen::Index>> groups{{0}};
  std::vector<std::size_t> group_of(tree.size() + 1, 0);
  for (const Branch& branch : tree) {
    const bool same = branch.length <= longest;
    const std::size_t group =
        same ? group_of[static_cast<std::size_t>(branch.parent)] : groups.size();
    if (!same) groups.emplace_back();
    groups[group].push_back(branch.site);
    group_of[static_cast<std::size_t>(branch.site)] = group;
  }
  return groups;
}

/// Returns the median width of the groups of several sites; lines of sites are wide.
double usual_width(const std::vector<std::vector<Eigen::Index>>& groups, const MapSites& sites) {
  std::vector<double> widths;
  for (const auto& group : groups) {
    if (group.size() < 2) continue;
    Eigen::AlignedBox2d box;
    for (const Eigen::Index i : group) box.extend(Eigen::Vector2d(sites.positions.col(i)));
    widths.push_back(box.diagonal().norm());
  }
  return median(widths);
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

std::vector<ErrorSample> with_found_places(std::vector<ErrorSample> samples,
                                           const MapSites& sites) {
  if (sites.size() > kMostSearched) return samples;
  const std::vector<Branch> tree = shortest_tree(sites.positions);
  const auto gap = widest_gap(tree);
  if (!gap) return samples;
  const auto groups = joined(tree, std::sqrt(gap->within * gap->between));
  if (groups.size() < kFewestPlaces || usual_width(groups, sites) > gap->between) return samples;
  for (std::size_t place = 0; place < groups.size(); ++place)
    for (const Eigen::Index site : groups[place])
      for (const std::size_t i : sites.samples[static_cast<std::size_t>(site)])
        samples[i].place = std::to_string(place);
  return samples;
}

}  // namespace planar
