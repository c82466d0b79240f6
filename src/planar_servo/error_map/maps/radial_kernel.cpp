#include "planar_servo/error_map/maps/radial_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "planar_servo/error_map/numerics/avx2_clones.h"

namespace planar {
namespace {

/// The level divided by the largest value of sqrt(1 + u^2). It is twice what positions all over a
/// disc, as wide as the kernel, need.
constexpr double kLevelOverFarthest = 4.0;

/// Returns exp(x) of x <= 0 to within 1.4e-16 of itself; 0 below the smallest normal number, NaN of
/// NaN. A loop can vectorise its steps. It is 2^k exp(rest), with k read from the last bits of a
/// sum whose unit they are, and the Taylor series of exp(rest), |rest| < 0.35.
inline double exponential(double x) {
  constexpr double kLeast = -708.0;
  constexpr double kUnit = 0x1.8p52;
  constexpr double kLog2 = 0x1.62e42fefa39efp-1;
  constexpr double kLog2High = 0x1.62e4p-1, kLog2Low = 0x1.7f7d1cf79abcap-20;  // k times high exact
  constexpr double kFactorials[] = {6227020800.0, 479001600.0, 39916800.0, 3628800.0, 362880.0,
                                    40320.0,      5040.0,      720.0,      120.0,     24.0,
                                    6.0,          2.0,         1.0,        1.0};
  const double clamped = std::max(x, kLeast);
  const double sum = clamped * (1.0 / kLog2) + kUnit;
  const double k = sum - kUnit;
  const double rest = (clamped - k * kLog2High) - k * kLog2Low;
  double power = 0.0;
  for (const double factorial : kFactorials) power = power * rest + 1.0 / factorial;
  std::uint64_t exponent = 0, bits = 0;
  std::memcpy(&exponent, &sum, sizeof exponent);
  std::memcpy(&bits, &power, sizeof bits);
  bits += exponent << 52;
  std::memcpy(&power, &bits, sizeof power);
  return x < kLeast ? 0.0 : power;
}

PLANAR_AVX2_CLONES void gaussian(double rate, const double* distances2, Eigen::Index n,
                                 double* values) {
#pragma omp simd
  for (Eigen::Index i = 0; i < n; ++i) values[i] = exponential(rate * distances2[i]);
}

PLANAR_AVX2_CLONES void multiquadric(double rate, double level, const double* distances2,
                                     Eigen::Index n, double* values) {
#pragma omp simd
  for (Eigen::Index i = 0; i < n; ++i)
    values[i] = (1.0 + 1.0 / level) - std::sqrt(1.0 + rate * distances2[i]) * (1.0 / level);
}

/// Writes the kernel of n squared distances to `values`, which may be the same memory.
void evaluate(const RadialKernel& kernel, const double* distances2, Eigen::Index n,
              double* values) {
  const double rate = 1.0 / (kernel.width * kernel.width);
  switch (kernel.shape) {
    case KernelShape::kGaussian:
      return gaussian(-0.5 * rate, distances2, n, values);
    case KernelShape::kMultiquadric:
      return multiquadric(rate, kernel.level(), distances2, n, values);
  }
}

}  // namespace

double RadialKernel::level() const {
  return kLevelOverFarthest * std::hypot(1.0, span / width);
}

double span_of(const Eigen::Matrix2Xd& positions) {
  return (positions.rowwise().maxCoeff() - positions.rowwise().minCoeff()).norm();
}

Eigen::MatrixXd squared_distances(const Eigen::Matrix2Xd& positions) {
  const Eigen::Index n = positions.cols();
  Eigen::MatrixXd distances2(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    distances2.col(j).tail(n - j) =
        (positions.rightCols(n - j).colwise() - positions.col(j)).colwise().squaredNorm();
  }
  return distances2;
}

void kernel_matrix(const RadialKernel& kernel, const Eigen::MatrixXd& squared_distances,
                   Eigen::MatrixXd& matrix) {
  const Eigen::Index n = squared_distances.cols();
  matrix.resize(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    evaluate(kernel, &squared_distances(j, j), n - j, &matrix(j, j));
  }
}

Eigen::VectorXd kernel_at(const RadialKernel& kernel, const Eigen::MatrixX2d& centers,
                          const Eigen::Vector2d& p) {
  Eigen::VectorXd values =
      (centers.col(0).array() - p.x()).square() + (centers.col(1).array() - p.y()).square();
  evaluate(kernel, values.data(), values.size(), values.data());
  return values;
}

}  // namespace planar
