#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace planar {

/// Where a turning joint has its axis.
struct AxisPlace {
  Eigen::Vector2d p{0.0, 0.0};  ///< metres, in the frame of the points
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};
  double radius{0.0};
};

/// Fits a circle to points that a joint carries round, by Gauss-Newton on their distances from it.
/// `sigma` is the least standard deviation per axis of a point that is believed; the points' own
/// scatter may raise it. Empty for fewer than 6 points and where an arc is too short to tell.
std::optional<AxisPlace> fit_axis(const std::vector<Eigen::Vector2d>& points, double sigma);

}  // namespace planar
