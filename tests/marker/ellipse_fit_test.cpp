#include "marker/ellipse_fit.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/units.h"

namespace planar {
namespace {

const Eigen::Vector2d kCenter(1203.3, 877.8);
constexpr double kNoise_px = 0.05;
constexpr int kReach = 6;

struct Ellipse {
  double a, b, direction;
};

std::vector<Eigen::Vector2d> rim(const Ellipse& ellipse, int n, double noise, std::mt19937& random,
                                 double from = 0.0, double to = 2.0 * kPi) {
  std::normal_distribution<double> normal(0.0, 1.0);
  const Eigen::Rotation2Dd turn(ellipse.direction);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < n; ++i) {
    const double t = from + (to - from) * i / n;
    const Eigen::Vector2d p(ellipse.a * std::cos(t), ellipse.b * std::sin(t));
    const Eigen::Vector2d normal_direction(std::cos(t) / ellipse.a, std::sin(t) / ellipse.b);
    points.push_back(kCenter + turn * (p + noise * normal(random) * normal_direction.normalized()));
  }
  return points;
}

TEST_CASE("fit_rim gives back an exact ellipse and an exact circle") {
  constexpr double kExact = 1e-6;  // where Gauss-Newton stops, with room
  std::mt19937 random(1);
  const auto ellipse = fit_rim(rim({24.0, 15.0, 0.6}, 120, 0.0, random), kReach);
  REQUIRE(ellipse);
  CHECK_FALSE(ellipse->is_circle);
  CHECK((ellipse->center - kCenter).norm() < kExact);
  CHECK(ellipse->diameter() == Approx(2.0 * std::sqrt(24.0 * 15.0)));
  const auto circle = fit_rim(rim({20.0, 20.0, 0.0}, 120, 0.0, random), kReach);
  REQUIRE(circle);
  CHECK((circle->center - kCenter).norm() < kExact);
  CHECK(circle->diameter() == Approx(40.0));
}

TEST_CASE("fit_rim takes the circle for a noisy circle and the ellipse for a noisy ellipse") {
  std::mt19937 random(2);
  int circles = 0, ellipses = 0;
  for (int i = 0; i < 50; ++i) {
    circles += fit_rim(rim({20.0, 20.0, 0.0}, 126, kNoise_px, random), kReach)->is_circle ? 1 : 0;
    ellipses += fit_rim(rim({20.0, 18.0, 1.0}, 126, kNoise_px, random), kReach)->is_circle ? 0 : 1;
  }
  CHECK(circles >= 45);
  CHECK(ellipses == 50);
}

TEST_CASE("fit_rim's covariance is that of its centre") {
  std::mt19937 random(3);
  constexpr int kRuns = 400;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero(), stated = Eigen::Matrix2d::Zero();
  for (int i = 0; i < kRuns; ++i) {
    const auto fit = fit_rim(rim({20.0, 20.0, 0.0}, 126, kNoise_px, random), kReach);
    REQUIRE(fit);
    const Eigen::Vector2d e = fit->center - kCenter;
    scatter += e * e.transpose() / kRuns;
    stated += fit->center_covariance / kRuns;
  }
  // theory.md: s sqrt(2 / N) per axis; 400 runs give a variance to 7 % (one sigma).
  const double expected = kNoise_px * kNoise_px * 2.0 / 126.0;
  for (const int axis : {0, 1}) {
    CHECK(scatter(axis, axis) == Approx(expected).epsilon(0.25));
    CHECK(stated(axis, axis) == Approx(expected).epsilon(0.25));
  }
}

TEST_CASE("fit_rim's covariance counts neighbours that share their noise only once") {
  constexpr int kRuns = 200, kShared = 4;
  std::mt19937 random(4);
  double alone = 0.0, shared = 0.0;
  for (int i = 0; i < kRuns; ++i) {
    const auto points = rim({20.0, 20.0, 0.0}, 126, kNoise_px, random);
    std::vector<Eigen::Vector2d> averaged;  // residuals averaged over a sliding window
    for (std::size_t k = 0; k < points.size(); ++k) {
      double sum = 0.0;
      for (std::size_t j = 0; j < kShared; ++j) {
        sum += (points[(k + j) % points.size()] - kCenter).norm() / kShared;
      }
      averaged.push_back(kCenter + sum * (points[k] - kCenter).normalized());
    }
    alone += fit_rim(points, kReach)->center_covariance.trace() / kRuns;
    shared += fit_rim(averaged, kReach)->center_covariance.trace() / kRuns;
  }
  // Averaging neighbours makes each edge better but, all round the rim, the centre no better.
  CHECK(shared / alone == Approx(1.0).margin(0.3));
}

TEST_CASE("fit_rim is not moved by a bite out of the rim and by stray edges") {
  std::mt19937 random(5);
  auto points = rim({20.0, 20.0, 0.0}, 126, kNoise_px, random);
  for (auto& p : points) {  // a flat cut at 0.85 R
    const Eigen::Vector2d d = p - kCenter;
    if (d.x() > 17.0) p.x() = kCenter.x() + 17.0;
  }
  for (int i = 0; i < 8; ++i) points.push_back(kCenter + Eigen::Vector2d(-14.0 + i, 3.0));
  const auto fit = fit_rim(points, kReach);
  REQUIRE(fit);
  constexpr double kSix = 6.0;  // standard deviations of the centre
  CHECK((fit->center - kCenter).norm() < kSix * kNoise_px * std::sqrt(2.0 / 100.0));
  CHECK(fit->largest_gap > 40.0 * kDegree);
}

TEST_CASE("fit_rim tells the angle that a partial rim leaves open") {
  std::mt19937 random(6);
  const auto fit = fit_rim(rim({20.0, 20.0, 0.0}, 90, 0.01, random, 0.0, kPi), kReach);
  REQUIRE(fit);
  CHECK(fit->largest_gap == Approx(kPi).margin(0.2));
}

TEST_CASE("fit_rim is empty for too few points and for points on a line") {
  CHECK_FALSE(fit_rim({}, kReach));
  CHECK_FALSE(fit_rim({{0, 0}, {1, 0}, {0, 1}, {1, 1}}, kReach));
  std::vector<Eigen::Vector2d> line;
  for (int i = 0; i < 40; ++i) line.emplace_back(i, 2.0 * i);
  CHECK_FALSE(fit_rim(line, kReach));
}

}  // namespace
}  // namespace planar
