#include "planar_servo/learn/error_map/maps/rbf_basis.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

namespace planar {
namespace {

// Twice the unit roundoff: of the exponential, and of its argument near 0.
constexpr double kKernelRounding = 4.4e-16;

Eigen::VectorXd at_distances(const RadialKernel& kernel, const Eigen::VectorXd& distances) {
  Eigen::MatrixX2d centers = Eigen::MatrixX2d::Zero(distances.size(), 2);
  centers.col(0) = distances;
  return kernel_at(kernel, centers, {0.0, 0.0});
}

TEST_CASE("Both kernels are what they are said to be at any distance") {
  const Eigen::Index n = 10007;
  const Eigen::VectorXd distances = Eigen::VectorXd::LinSpaced(n, 0.0, 37.0);  // to exp(-685)
  const Eigen::VectorXd gaussian = at_distances({KernelShape::kGaussian, 1.0, 0.0}, distances);
  const RadialKernel hill{KernelShape::kMultiquadric, 1.0, 2.0};
  const Eigen::VectorXd multiquadric = at_distances(hill, distances);
  double worst_gaussian = 0.0, worst_multiquadric = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double d = distances[i];
    const double expected = std::exp(-0.5 * (d * d));
    worst_gaussian = std::max(worst_gaussian, std::abs(gaussian[i] / expected - 1.0));
    const double rise = (std::sqrt(1.0 + d * d) - 1.0) / hill.level();
    worst_multiquadric = std::max(worst_multiquadric, std::abs(multiquadric[i] - (1.0 - rise)));
  }
  CHECK(worst_gaussian < kKernelRounding);
  CHECK(worst_multiquadric < 10.0 * kKernelRounding);  // 37 / level is above 4
  CHECK(gaussian[0] == 1.0);
}

TEST_CASE("Far away the Gaussian is nothing, and of no distance no number") {
  const double infinity = std::numeric_limits<double>::infinity();
  Eigen::VectorXd distances(6);
  distances << 37.7, 1e3, 1e160, infinity, std::numeric_limits<double>::quiet_NaN(), 1.0;
  const Eigen::VectorXd values = at_distances({KernelShape::kGaussian, 1.0, 0.0}, distances);
  CHECK(values.head(4).isZero(0.0));
  CHECK(std::isnan(values[4]));
  CHECK(values[5] == Approx(std::exp(-0.5)));
  const RadialKernel hill{KernelShape::kMultiquadric, 1.0, 2.0};
  CHECK(std::isnan(at_distances(hill, distances)[4]));
}

}  // namespace
}  // namespace planar
