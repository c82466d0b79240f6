#include "planar_servo/learn/error_map/error_sample.h"

#include <algorithm>
#include <limits>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/statistics.h"

namespace planar {
namespace {

Eigen::Vector2d nearest_of_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                                   const Eigen::Vector2d& b) {
  const Eigen::Vector2d edge = b - a;
  const double length2 = edge.squaredNorm();
  const double along = length2 > 0.0 ? std::clamp((p - a).dot(edge) / length2, 0.0, 1.0) : 0.0;
  return a + along * edge;
}

bool is_within(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& p) {
  bool within = hull.size() >= 3;
  for (std::size_t i = 0; i < hull.size(); ++i)
    within = within && cross2d(hull[(i + 1) % hull.size()] - hull[i], p - hull[i]) >= 0.0;
  return within;
}

/// Returns from p to the nearest place on the hull's edge; infinite without a corner.
Eigen::Vector2d to_edge(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& p) {
  Eigen::Vector2d nearest = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d way = nearest_of_segment(p, hull[i], hull[(i + 1) % hull.size()]) - p;
    if (way.squaredNorm() < nearest.squaredNorm()) nearest = way;
  }
  return nearest;
}

/// Returns one chain of the hull of points sorted by x, then y [Andrew 1979].
template <typename Iterator>
std::vector<Eigen::Vector2d> monotone_chain(Iterator first, Iterator last) {
  std::vector<Eigen::Vector2d> chain;
  for (; first != last; ++first) {
    while (chain.size() >= 2 &&
           cross2d(chain.back() - chain[chain.size() - 2], *first - chain.back()) <= 0.0)
      chain.pop_back();
    chain.push_back(*first);
  }
  chain.pop_back();
  return chain;
}

std::vector<Eigen::Vector2d> convex_hull(const Eigen::Matrix2Xd& positions) {
  std::vector<Eigen::Vector2d> points;
  for (Eigen::Index i = 0; i < positions.cols(); ++i) points.emplace_back(positions.col(i));
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  std::vector<Eigen::Vector2d> hull = monotone_chain(points.begin(), points.end());
  const std::vector<Eigen::Vector2d> upper = monotone_chain(points.rbegin(), points.rend());
  hull.insert(hull.end(), upper.begin(), upper.end());
  return hull;
}

}  // namespace

bool ValidRegion::contains(const Eigen::Vector2d& p) const {
  return is_within(hull, p) || to_edge(hull, p).norm() <= margin;
}

Eigen::Vector2d ValidRegion::nearest(const Eigen::Vector2d& p) const {
  if (contains(p)) return p;
  const Eigen::Vector2d way = to_edge(hull, p);
  return p + (1.0 - margin / way.norm()) * way;
}

double median_spacing(const Eigen::Matrix2Xd& positions) {
  std::vector<double> nearest;
  for (Eigen::Index i = 0; i < positions.cols(); ++i) {
    Eigen::ArrayXd distance2 = (positions.colwise() - positions.col(i)).colwise().squaredNorm();
    distance2[i] = std::numeric_limits<double>::infinity();
    nearest.push_back(std::sqrt(distance2.minCoeff()));
  }
  return median(nearest);
}

ValidRegion region_around(const Eigen::Matrix2Xd& positions) {
  return region_around(positions, median_spacing(positions));
}

ValidRegion region_around(const Eigen::Matrix2Xd& positions, double margin) {
  return {convex_hull(positions), margin};
}

}  // namespace planar
