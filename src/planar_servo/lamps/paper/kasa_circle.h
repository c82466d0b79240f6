#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace planar {

struct Circle {
  Eigen::Vector2d center{0.0, 0.0};
  double radius{0.0};
};

/// Returns the circle that minimises the sum of (x^2 + y^2 + a x + b y + c)^2, in closed form [Kasa
/// 1976]. Empty for fewer than three points and for points nearly on one line.
std::optional<Circle> kasa_circle(const std::vector<Eigen::Vector2d>& points);

}  // namespace planar
