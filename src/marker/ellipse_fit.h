#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace planar {

/// An ellipse |shape (p - center)| = 1 fitted to the edge points of a rim.
struct RimFit {
  Eigen::Vector2d center{0.0, 0.0};
  Eigen::Matrix2d shape{Eigen::Matrix2d::Identity()};  ///< symmetric; identity / radius of a circle
  bool is_circle{true};
  Eigen::Matrix2d center_covariance{Eigen::Matrix2d::Zero()};
  double sigma{0.0};        ///< standard deviation of one edge, across the rim
  double largest_gap{0.0};  ///< widest angle at the centre without an edge that was used, radians
  int used{0};              ///< edges that were not rejected

  /// Of the circle with the ellipse's area.
  double diameter() const;
};

/// Fits by least squares of distances (Gauss-Newton, distances to first order), drops edges beyond
/// 3 robust standard deviations in rounds. The ellipse is taken only when it explains the edges
/// better than the circle by more than its two further parameters deserve [Schwarz 1978]. The
/// covariance is s^2 (J^T J)^-1, widened because neighbouring edges, up to `reach` places apart
/// along the rim, share pixels (see edge_noise.h). Empty for too few points, points on a line, or
/// no convergence.
std::optional<RimFit> fit_rim(const std::vector<Eigen::Vector2d>& edges, int reach);

}  // namespace planar
