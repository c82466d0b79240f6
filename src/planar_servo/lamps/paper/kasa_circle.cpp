#include "planar_servo/lamps/paper/kasa_circle.h"

#include <Eigen/LU>
#include <cmath>

namespace planar {

std::optional<Circle> kasa_circle(const std::vector<Eigen::Vector2d>& points) {
  if (points.size() < 3) return std::nullopt;
  const double n = static_cast<double>(points.size());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) mean += p / n;

  // Relative to the mean, the sums of x and y vanish, which leaves two equations for a and b.
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  Eigen::Vector2d third = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d d = p - mean;
    moments += d * d.transpose();
    third += d.squaredNorm() * d;
  }
  constexpr double kLeastDeterminant = 1e-9;  // the points' width divided by their length, squared
  const double determinant = moments.determinant();
  if (!(determinant > kLeastDeterminant * moments.trace() * moments.trace())) return std::nullopt;

  const Eigen::Vector2d center = 0.5 * moments.inverse() * third;
  return Circle{mean + center, std::sqrt(moments.trace() / n + center.squaredNorm())};
}

}  // namespace planar
