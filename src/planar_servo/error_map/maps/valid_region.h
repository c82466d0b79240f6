#pragma once

#include <Eigen/Core>
#include <vector>

namespace planar {

/// Where a map is valid: the convex hull of its samples widened by a margin.
struct ValidRegion {
  std::vector<Eigen::Vector2d> hull;  ///< corners, counterclockwise; two when collinear; metres
  double margin{0.0};                 ///< metres

  /// Whether p lies within the hull or at most `margin` from it.
  bool contains(const Eigen::Vector2d& p) const;
};

/// The hull of `positions` (one column each) with their median nearest-neighbour distance as the
/// margin: as far beyond the rim as samples are apart.
ValidRegion region_around(const Eigen::Matrix2Xd& positions);

/// The same with another margin, metres.
ValidRegion region_around(const Eigen::Matrix2Xd& positions, double margin);

/// Median distance from a position to the nearest other one, metres; at least two positions.
double median_spacing(const Eigen::Matrix2Xd& positions);

}  // namespace planar
