#include "planar_servo/servo/landing_filter.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// The share of a correction by which the persistent error may change: gear ripple of 0.02 degrees
/// and a period of 3.6 degrees changes by 3.5 % of a turn, links off by 1 % add little.
constexpr double kChangePerStep = 0.035;

Eigen::Matrix2d isotropic(double deviation) {
  return deviation * deviation * Eigen::Matrix2d::Identity();
}

/// Returns the covariance of d + v with (d, v).
Eigen::Matrix<double, 4, 2> with_sight(const Eigen::Matrix4d& covariance) {
  return covariance.leftCols<2>() + covariance.rightCols<2>();
}

Eigen::Matrix2d sight_covariance(const Eigen::Matrix4d& covariance, const LandingLook& look) {
  const Eigen::Matrix<double, 4, 2> cross = with_sight(covariance);
  return cross.topRows<2>() + cross.bottomRows<2>() + isotropic(look.scatter_m) +
         isotropic(look.noise_m);
}

/// Returns the covariance of where the stop lands with where it is seen.
Eigen::Matrix2d landing_with_sight(const Eigen::Matrix4d& covariance, const LandingLook& look) {
  return with_sight(covariance).topRows<2>() + isotropic(look.scatter_m);
}

/// Returns the mean of the smaller one of a limit and the length of a vector whose components
/// deviate by `deviation_m`.
double mean_below_m(double deviation_m, double limit_m) {
  if (deviation_m == 0.0) return 0.0;
  return std::sqrt(0.5 * kPi) * deviation_m * std::erf(limit_m / (std::sqrt(2.0) * deviation_m));
}

}  // namespace

double Innovation::chi_squared() const {
  return value.dot(covariance.inverse() * value);
}

double Innovation::log_likelihood() const {
  return -0.5 * (chi_squared() + std::log(covariance.determinant())) - std::log(2.0 * kPi);
}

Eigen::Matrix4d LandingFilter::covariance_at(const Eigen::Vector2d& p_c) const {
  Eigen::Matrix4d covariance = covariance_;
  if (has_looked_)
    covariance.topLeftCorner<2, 2>() += isotropic(kChangePerStep * (p_c - p_c_).norm());
  return covariance;
}

Innovation LandingFilter::innovation(const LandingLook& look) const {
  return {look.p - look.p_c - mean_.head<2>() - mean_.tail<2>(),
          sight_covariance(covariance_at(look.p_c), look)};
}

void LandingFilter::take(const LandingLook& look) {
  const Innovation found = innovation(look);
  covariance_ = covariance_at(look.p_c);
  const Eigen::Matrix2d weight = found.covariance.inverse();
  const Eigen::Matrix2d cross = landing_with_sight(covariance_, look);
  landing_.mean = look.p_c + mean_.head<2>() + cross * weight * found.value;
  landing_.covariance = covariance_.topLeftCorner<2, 2>() + isotropic(look.scatter_m) -
                        cross * weight * cross.transpose();
  const Eigen::Matrix<double, 4, 2> gain = with_sight(covariance_) * weight;
  mean_ += gain * found.value;
  covariance_ -= gain * with_sight(covariance_).transpose();
  covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
  p_c_ = look.p_c;
  has_looked_ = true;
}

PlaneEstimate LandingFilter::persistent_error() const {
  return {mean_.head<2>(), covariance_.topLeftCorner<2, 2>()};
}

double LandingFilter::revealed_m(const LandingLook& next) const {
  const Eigen::Matrix4d covariance = covariance_at(next.p_c);
  const Eigen::Matrix2d cross = landing_with_sight(covariance, next);
  const Eigen::Matrix2d revealed =
      cross * sight_covariance(covariance, next).inverse() * cross.transpose();
  return std::sqrt(0.5 * revealed.trace());
}

Spread LandingFilter::spread(const LandingLook& next) const {
  LandingFilter later = *this;
  later.take(next);
  return {revealed_m(next), later.revealed_m(next)};
}

double nearest_expected_m(const Spread& spread, int corrections) {
  double nearest_m = std::numeric_limits<double>::infinity();  // the last place must do
  for (int left = 1; left <= corrections; ++left)
    nearest_m = mean_below_m(left < corrections ? spread.later_m : spread.next_m, nearest_m);
  return nearest_m;
}

}  // namespace planar
