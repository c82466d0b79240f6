#include "planar_servo/error_map/judge/gross_outliers.h"

#include <algorithm>
#include <numeric>

#include "planar_servo/core/numerics/statistics.h"

namespace planar {
namespace {

constexpr Eigen::Index kNeighbours = 12;

/// The limit of a difference over the median difference. It is wide, because the field itself
/// differs over this distance.
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

/// Returns the median error of these sites per axis.
Eigen::Vector2d median_error(const MapSites& sites, const std::vector<Eigen::Index>& of) {
  std::vector<double> x;
  std::vector<double> y;
  for (const Eigen::Index site : of) {
    x.push_back(sites.errors(0, site));
    y.push_back(sites.errors(1, site));
  }
  return {median(x), median(y)};
}

}  // namespace

Neighbours nearest_sites(const MapSites& sites) {
  Neighbours neighbours;
  for (Eigen::Index i = 0; i < sites.size(); ++i) neighbours.push_back(nearest_to(i, sites));
  return neighbours;
}

std::vector<Eigen::Index> sites_like_their_neighbours(const MapSites& sites,
                                                      const Neighbours& neighbours) {
  std::vector<double> differences;
  for (Eigen::Index i = 0; i < sites.size(); ++i) {
    differences.push_back(
        (sites.errors.col(i) - median_error(sites, neighbours[static_cast<std::size_t>(i)]))
            .norm());
  }
  const double limit = kGross * median(differences);
  std::vector<Eigen::Index> alike;
  for (Eigen::Index i = 0; i < sites.size(); ++i)
    if (differences[static_cast<std::size_t>(i)] <= limit) alike.push_back(i);
  return alike;
}

}  // namespace planar
