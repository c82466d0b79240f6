#include "planar_servo/loop/servo/landing_estimator.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// Returns the covariance of (d, v) for deviations per axis and their correlation.
Eigen::Matrix4d prior_of(double d_m, double v_m, double correlation = 0.0) {
  Eigen::Matrix4d prior = Eigen::Matrix4d::Zero();
  prior.diagonal() << d_m * d_m, d_m * d_m, v_m * v_m, v_m * v_m;
  prior.topRightCorner<2, 2>().diagonal().setConstant(correlation * d_m * v_m);
  prior.bottomLeftCorner<2, 2>() = prior.topRightCorner<2, 2>();
  return prior;
}

}  // namespace

TEST_CASE("After two looks without a move between them the filter is the closed form of weights") {
  const double d = 60e-6, v = 12e-6, s = 10e-6, n = 2e-6;
  const Eigen::Vector2d c{0.2, 0.1}, z1 = c + Eigen::Vector2d(50e-6, -30e-6),
                                     z2 = c + Eigen::Vector2d(70e-6, 10e-6);
  LandingFilter filter(prior_of(d, v));
  filter.take({c, z1, n, s});
  filter.take({c, z2, n, s});
  // The looks are d + v with independent noise s + n each: only their mean says something of d.
  const double noise = s * s + n * n, both = d * d + v * v;
  const double of_mean = both / (both + noise / 2.0);
  const Eigen::Vector2d sight = of_mean * (0.5 * (z1 + z2) - c);
  const Eigen::Vector2d wanted = d * d / both * sight;
  // The landing adds what the last look leaves beside d + v, shared between scatter and noise.
  const Eigen::Vector2d landing = c + wanted + s * s / noise * (z2 - c - sight);
  CHECK((filter.landing().mean - landing).norm() < 1e-15);
  CHECK((filter.next_command(c) - (c - wanted)).norm() < 1e-15);
  // A stop without scatter that is hardly seen lands where the arm's persistent error puts it.
  filter.take({c, z2, 1.0, 0.0});
  CHECK((filter.landing().mean - c - wanted).norm() < 1e-14);
  const double variance = d * d - d * d * d * d / (both + noise / 2.0);
  CHECK(filter.landing().covariance(0, 0) == Approx(variance));
}

TEST_CASE("A landing's stated deviation is that of its errors, with errors that go together") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto draw = [&](double deviation) {
    return Eigen::Vector2d{deviation * normal(random), deviation * normal(random)};
  };
  const double d_m = 20e-6, v_m = 15e-6, correlation = -0.6, s = 8e-6, n = 3e-6;
  double squares = 0.0, stated = 0.0;
  constexpr int kRuns = 2000;
  for (int run = 0; run < kRuns; ++run) {
    LandingFilter filter(prior_of(d_m, v_m, correlation));
    const Eigen::Vector2d unit = draw(1.0), d = d_m * unit;
    const Eigen::Vector2d v =
        v_m * (correlation * unit + std::sqrt(1.0 - correlation * correlation) * draw(1.0));
    Eigen::Vector2d c = Eigen::Vector2d::Zero(), landing = c;
    for (int look = 0; look < 3; ++look) {
      landing = c + d + draw(s);
      filter.take({c, landing + v + draw(n), n, s});
      c = filter.next_command(Eigen::Vector2d::Zero());
    }
    squares += (filter.landing().mean - landing).squaredNorm();
    stated += filter.landing().covariance.trace();
  }
  CHECK(squares / stated == Approx(1.0).epsilon(0.07));  // 3 deviations of 2 x 2000 squares: 6.7 %
}

TEST_CASE("A long correction lets the persistent error change by some per cent of it") {
  LandingFilter filter(prior_of(1e-3, 0.0));
  filter.take({{0.0, 0.0}, {2e-3, 0.0}, 1e-6, 1e-6});
  const double before = std::sqrt(filter.innovation({{0.0, 0.0}, {}, 0.0, 0.0}).covariance(0, 0));
  const double after = std::sqrt(filter.innovation({{-2e-3, 0.0}, {}, 0.0, 0.0}).covariance(0, 0));
  CHECK(before < 2e-6);
  CHECK(after == Approx(70e-6).epsilon(0.01));
}

TEST_CASE("The spread of what is known next is what looks can reveal, not what they never see") {
  const double d = 7e-6, v = 1.0, s = 5e-6, n = 1e-9;
  LandingFilter blind(prior_of(d, v));  // vision knows nothing of the place
  blind.take({{0.0, 0.0}, {0.3, 0.0}, n, s});
  CHECK(blind.next_command({0.0, 0.0}).norm() < 1e-9);
  // The second look tells its own stop from the first one's: half of each of the two.
  const Spread spread = blind.spread({{0.0, 0.0}, {}, n, s});
  CHECK(spread.next_m == Approx(s / std::sqrt(2.0)).epsilon(0.01));
  // The third look knows the arm from two stops already: two thirds are revealed.
  CHECK(spread.later_m == Approx(s * std::sqrt(2.0 / 3.0)).epsilon(0.01));
}

TEST_CASE("Who stops when it is best ends as near as a simulation does") {
  CHECK(nearest_expected_m({1.0, 9.0}, 1) == Approx(std::sqrt(kPi / 2.0)));
  CHECK(nearest_expected_m({0.0, 0.0}, 5) == 0.0);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  double sum = 0.0;
  constexpr int kRuns = 20000;
  for (int run = 0; run < kRuns; ++run) {
    double miss = 0.0;
    for (int left = 4; left >= 0; --left) {
      miss = std::hypot(normal(random), normal(random)) * (left == 4 ? 3.0 : 1.0);
      if (left > 0 && miss <= nearest_expected_m({1.0, 1.0}, left)) break;
    }
    sum += miss;
  }
  CHECK(sum / kRuns == Approx(nearest_expected_m({3.0, 1.0}, 5)).epsilon(0.02));
}

TEST_CASE("An innovation's chi squared and likelihood are those of the normal distribution") {
  Innovation innovation{{3.0, 4.0}, Eigen::Vector2d(4.0, 16.0).asDiagonal()};
  CHECK(innovation.chi_squared() == Approx(9.0 / 4.0 + 1.0));
  CHECK(innovation.log_likelihood() ==
        Approx(-0.5 * 3.25 - 0.5 * std::log(64.0) - std::log(2.0 * kPi)));
}

}  // namespace planar
