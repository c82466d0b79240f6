#include "planar_servo/error_map/fit/found_places.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "planar_servo/core/statistics.h"

namespace planar {
namespace {

/// The tree takes time with the square of the positions.
constexpr Eigen::Index kMostSearched = 5000;

/// At least this share of the tree's branches must lie within places, and there must be so many
/// places; otherwise a few neighbours that are close by chance would count as places.
constexpr double kLeastWithin = 0.2;
constexpr std::size_t kFewestPlaces = 10;

/// Branches between places are at least this many times as long as those within, but for a share
/// of them: two places may be close by chance.
constexpr double kLeastRatio = 2.0;
constexpr double kOverlap = 0.05;

/// Joins a site to the part of the tree that was there before.
struct Branch {
  Eigen::Index site{0};
  Eigen::Index parent{0};
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
  double within{0.0};
  double between{0.0};

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
