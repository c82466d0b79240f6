#include "planar_servo/calibration/readings/joint1_axis.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "planar_servo/core/decompositions.h"

namespace planar {
namespace {

constexpr std::size_t kFewestPoints = 6;
constexpr int kSteps = 10;
/// The equations are solved for centre and radius in units of a point's noise; an arc below some
/// twenty degrees gives less.
constexpr double kLeastRcond = 1e-5;

/// Returns the circle by the linear equations |p|^2 = 2 c p + (r^2 - |c|^2) [Kasa 1976], from which
/// the distances are improved.
Eigen::Vector3d first_circle(const std::vector<Eigen::Vector2d>& points) {
  Eigen::MatrixXd A(static_cast<Eigen::Index>(points.size()), 3);
  Eigen::VectorXd b(A.rows());
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const Eigen::Vector2d& p = points[static_cast<std::size_t>(i)];
    A.row(i) << 2.0 * p.x(), 2.0 * p.y(), 1.0;
    b[i] = p.squaredNorm();
  }
  const Eigen::Vector3d x = solve_least_squares(A, b);
  return {x.x(), x.y(), std::sqrt(std::max(0.0, x.z() + x.head<2>().squaredNorm()))};
}

}  // namespace

std::optional<AxisPlace> fit_axis(const std::vector<Eigen::Vector2d>& points, double sigma) {
  if (points.size() < kFewestPoints) return std::nullopt;
  Eigen::Vector3d circle = first_circle(points);
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd J(n, 3);
  Eigen::VectorXd left(n);
  for (int step = 0; step < kSteps; ++step) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Vector2d arm = points[static_cast<std::size_t>(i)] - circle.head<2>();
      J.row(i) << -arm.normalized().transpose(), -1.0;
      left[i] = arm.norm() - circle.z();
    }
    const auto change = solve_positive(J.transpose() * J, -J.transpose() * left, kLeastRcond);
    if (!change || !change->allFinite()) return std::nullopt;
    circle += *change;
  }
  const double variance = std::max(sigma * sigma, left.squaredNorm() / static_cast<double>(n - 3));
  const Eigen::Matrix3d covariance = variance * Eigen::Matrix3d(J.transpose() * J).inverse();
  return AxisPlace{circle.head<2>(), covariance.topLeftCorner<2, 2>(), circle.z()};
}

}  // namespace planar
