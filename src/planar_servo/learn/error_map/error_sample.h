#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
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

/// Returns the hull of `positions` (columns), widened by their median_spacing().
ValidRegion region_around(const Eigen::Matrix2Xd& positions);

/// Returns the hull of `positions`, widened by `margin` (metres).
ValidRegion region_around(const Eigen::Matrix2Xd& positions, double margin);

/// Returns the median distance from a position to its nearest neighbour, metres; two at least.
double median_spacing(const Eigen::Matrix2Xd& positions);

/// A calibration point: the end point as vision saw it and the vision error there (vision minus
/// tracker), both in the base frame, metres.
struct ErrorSample {
  std::string id;
  Eigen::Vector2d p_vision{0.0, 0.0};
  Eigen::Vector2d error{0.0, 0.0};
  double sigma{0.0};  ///< of `error` per axis, stated by the instruments, metres; 0 if unstated
  std::optional<double> phi{};  ///< tool's direction in the base frame, radians
  std::string place{};          ///< samples of one place share the name; empty when unknown
};

struct ErrorPrediction {
  Eigen::Vector2d error{0.0, 0.0};  ///< metres
  /// Standard deviation of `error` as the noise-free error, per axis, metres; NaN if not stated.
  double sigma{0.0};
  bool inside{false};  ///< whether the position is in the map's valid region
};

}  // namespace planar
