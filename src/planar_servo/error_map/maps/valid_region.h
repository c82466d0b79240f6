#pragma once

#include <Eigen/Core>
#include <vector>

namespace planar {

/// The region where a map is valid: the convex hull of its samples, widened by a margin.
struct ValidRegion {
  std::vector<Eigen::Vector2d> hull;  ///< corners, counterclockwise; two when collinear; metres
  double margin{0.0};                 ///< metres

  /// Returns whether p lies in the hull or at most `margin` from it.
  bool contains(const Eigen::Vector2d& p) const;
  /// Returns p, or the nearest place of the region when p lies outside it.
  Eigen::Vector2d nearest(const Eigen::Vector2d& p) const;
};

/// Returns the hull of `positions` (one column each), widened by their median distance to the
/// nearest neighbour.
ValidRegion region_around(const Eigen::Matrix2Xd& positions);

/// Returns the hull of `positions`, widened by `margin` (metres).
ValidRegion region_around(const Eigen::Matrix2Xd& positions, double margin);

/// Returns the median distance from a position to its nearest neighbour, metres; there must be at
/// least two.
double median_spacing(const Eigen::Matrix2Xd& positions);

}  // namespace planar
