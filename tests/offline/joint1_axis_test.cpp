#include "planar_servo/offline/pairs/recording_check.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

std::vector<Eigen::Vector2d> turned(const Eigen::Vector2d& axis, double arc, double noise,
                                    unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 24; ++i) {
    const double angle = arc * i / 24.0 + 2e-4 * normal(random);  // a reducer errs along the circle
    const Eigen::Vector2d on(std::cos(angle), std::sin(angle));
    points.emplace_back(axis + 0.42 * on + noise * Eigen::Vector2d{normal(random), normal(random)});
  }
  return points;
}

}  // namespace

TEST_CASE("The axis of a turning joint is found within its stated deviation, whatever the angles") {
  constexpr double kNoise = 0.010 * kMillimetre;
  constexpr int kSeeds = 400;
  const Eigen::Vector2d axis(1.0 * kMillimetre, -0.3 * kMillimetre);
  for (const double arc : {2.0 * kPi, 1.5}) {
    double square = 0.0;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
      const auto found = fit_axis(turned(axis, arc, kNoise, seed), kNoise);
      REQUIRE(found);
      const Eigen::Vector2d off = found->p - axis;
      square += off.dot(found->covariance.inverse() * off) / 2.0 / kSeeds;
    }
    INFO("an arc of " << arc);
    CHECK(square > 0.6);
    CHECK(square < 1.1);  // the scatter may raise the variance, never lower it
  }
}

TEST_CASE("Few points and short arcs show no axis") {
  CHECK_FALSE(fit_axis(std::vector<Eigen::Vector2d>(5, Eigen::Vector2d(1.0, 0.0)), 1e-5));
  CHECK_FALSE(fit_axis(std::vector<Eigen::Vector2d>(9, Eigen::Vector2d(1.0, 0.0)), 1e-5));
  CHECK_FALSE(fit_axis(turned({0.0, 0.0}, 0.05, 1e-5, 1), 1e-5));
}

}  // namespace planar
