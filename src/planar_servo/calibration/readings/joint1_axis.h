#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace planar {

/// The axis of a turning joint.
struct AxisPlace {
  Eigen::Vector2d p{0.0, 0.0};  ///< metres, in the frame of the points
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};
  double radius{0.0};
};

/// Fits a circle to points on a turning link, by Gauss-Newton on their distances from it. `sigma`
/// is the least standard deviation that is assumed for a point, per axis; the points' own scatter
/// may raise it. Empty for fewer than 6 points and for an arc that is too short.
std::optional<AxisPlace> fit_axis(const std::vector<Eigen::Vector2d>& points, double sigma);

}  // namespace planar
