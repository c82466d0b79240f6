#include "planar_servo/loop/servo/path/path.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kExact_m = 1e-12;

/// A line of 100 mm along x, then a quarter of a circle of 50 mm to the left.
Path line_and_quarter() {
  const double r = 0.05, h = r / std::sqrt(2.0);
  return Path({{{{0.2, 0.1}, 0.0}},
               {{{0.3, 0.1}, 1.0}},
               {{{0.35, 0.15}, 1.0}, Eigen::Vector2d(0.3 + h, 0.15 - h)}});
}

}  // namespace

TEST_CASE("A line and an arc have the length, places and tangents of geometry") {
  const Path path = line_and_quarter();
  CHECK(path.length_m() == Approx(0.1 + 0.05 * kPi / 2.0).epsilon(1e-12));
  CHECK((path.at(0.025).pose.p - Eigen::Vector2d(0.225, 0.1)).norm() < kExact_m);
  CHECK(path.at(0.025).pose.phi == Approx(0.25));
  CHECK((path.at(0.025).tangent - Eigen::Vector2d(1.0, 0.0)).norm() < kExact_m);
  const PathPlace middle = path.at(0.1 + 0.05 * kPi / 4.0);
  const double h = 0.05 / std::sqrt(2.0);
  CHECK((middle.pose.p - Eigen::Vector2d(0.3 + h, 0.15 - h)).norm() < kExact_m);
  CHECK((middle.tangent - Eigen::Vector2d(h, h) / 0.05).norm() < 1e-9);
  CHECK((path.at(-1.0).pose.p - Eigen::Vector2d(0.2, 0.1)).norm() < kExact_m);
  CHECK((path.at(9.0).pose.p - Eigen::Vector2d(0.35, 0.15)).norm() < kExact_m);
}

TEST_CASE(
    "An arc through a third place keeps its distance from one centre, whichever way it turns") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(-kPi, kPi), turn(0.1, 3.0);
  for (int i = 0; i < 200; ++i) {
    const double begin = angle(random), first = turn(random), second = turn(random);
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    const Eigen::Vector2d center(0.1, -0.2);
    const auto on = [&](double a) { return Eigen::Vector2d(center + 0.08 * rotation2d(a).col(0)); };
    const PathSegment arc = PathSegment::arc({on(begin), 0.0}, on(begin + sign * first),
                                             {on(begin + sign * (first + second)), 0.0});
    CHECK(arc.length_m() == Approx(0.08 * (first + second)));
    CHECK(arc.curvature() == Approx(1.0 / 0.08));
    for (const double share : {0.0, 0.3, 0.9})
      CHECK((arc.at(share * arc.length_m()).pose.p - on(begin + sign * share * (first + second)))
                .norm() < 1e-9);
  }
}

TEST_CASE("A point's offset from a path is positive on the left and tells how far along it lies") {
  const Path path = line_and_quarter();
  const PathOffset left = path.offset({0.25, 0.1002}, 0.05);
  CHECK(left.across_m == Approx(0.2e-3));
  CHECK(left.along_m == Approx(0.05));
  const Eigen::Vector2d outside = Eigen::Vector2d(0.3, 0.15) + 0.0503 * rotation2d(-0.5).col(0);
  const PathOffset right = path.offset(outside, 0.15);
  CHECK(right.across_m == Approx(-0.3e-3));
  CHECK(right.along_m == Approx(0.1 + 0.05 * (kPi / 2.0 - 0.5)));
}

TEST_CASE("Where a path crosses itself a point belongs to the part that is gone along") {
  const Path path({{{{0.0, 0.2}, 0.0}},
                   {{{0.1, 0.2}, 0.0}},
                   {{{0.1, 0.25}, 0.0}},
                   {{{0.05, 0.25}, 0.0}},
                   {{{0.05, 0.15}, 0.0}}});
  CHECK(path.offset({0.05, 0.2003}, 0.05).across_m == Approx(0.3e-3));
  CHECK(path.offset({0.05, 0.2003}, 0.25).along_m == Approx(0.2497));
}

TEST_CASE("Places that give no line and no arc are refused") {
  CHECK_THROWS_AS(Path({{{{0.1, 0.1}, 0.0}}}), std::invalid_argument);
  CHECK_THROWS_AS(PathSegment::line({{0.1, 0.1}, 0.0}, {{0.1, 0.1}, 1.0}), std::invalid_argument);
  CHECK_THROWS_WITH(PathSegment::arc({{0.1, 0.1}, 0.0}, {0.2, 0.1}, {{0.3, 0.1}, 0.0}),
                    Catch::Contains("one line"));
  CHECK_THROWS_WITH(PathSegment::arc({{0.1, 0.1}, 0.0}, {0.2, 0.1}, {{0.1, 0.1}, 0.0}),
                    Catch::Contains("a whole circle takes two arcs"));
}

}  // namespace planar
