#include "planar_servo/loop/servo/path/path.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace planar {
namespace {

Waypoint at(double x_m, double y_m) {
  return {{{x_m, y_m}, 0.0}};
}

double speed_at(const PathTiming& timing, double t_s) {
  constexpr double kStep_s = 1e-4;
  return (timing.along_m(t_s + kStep_s) - timing.along_m(t_s - kStep_s)) / (2.0 * kStep_s);
}

}  // namespace

TEST_CASE("A long line is travelled as a trapezoid, a short one as a triangle") {
  const PathTiming trapezoid(Path({at(0.2, 0.0), at(0.3, 0.0)}), 0.05);
  CHECK(trapezoid.duration_s() == Approx(0.1 / 0.05 + 0.05 / 0.1));
  CHECK(trapezoid.along_m(0.5) == Approx(0.0125));
  CHECK(trapezoid.along_m(1.5) == Approx(0.0625));
  CHECK(trapezoid.along_m(-1.0) == 0.0);
  CHECK(trapezoid.along_m(99.0) == Approx(0.1));
  const PathTiming triangle(Path({at(0.2, 0.0), at(0.21, 0.0)}), 0.05);
  CHECK(triangle.duration_s() == Approx(2.0 * std::sqrt(0.01 / 0.1)));
  CHECK(triangle.along_m(0.5 * triangle.duration_s()) == Approx(0.005));
}

TEST_CASE("The end point rests at a corner and does not slow down where segments join smoothly") {
  const PathTiming corner(Path({at(0.2, 0.0), at(0.3, 0.0), at(0.3, 0.1)}), 0.02);
  CHECK(corner.duration_s() == Approx(2.0 * (0.1 / 0.02 + 0.02 / 0.1)));
  CHECK(corner.along_m(0.5 * corner.duration_s()) == Approx(0.1));
  CHECK(speed_at(corner, 0.5 * corner.duration_s()) == Approx(0.0).margin(1e-4));
  const PathTiming straight(Path({at(0.2, 0.0), at(0.25, 0.0), at(0.3, 0.0)}), 0.02);
  CHECK(straight.duration_s() == Approx(0.1 / 0.02 + 0.02 / 0.1));
}

TEST_CASE("The end point waits where its path says so, even where segments join smoothly") {
  Waypoint waits = at(0.25, 0.0);
  waits.rest_s = 2.0;
  const PathTiming timing(Path({at(0.2, 0.0), waits, at(0.3, 0.0)}), 0.02);
  const double half_s = 0.05 / 0.02 + 0.02 / 0.1;
  CHECK(timing.duration_s() == Approx(2.0 * half_s + 2.0));
  CHECK(timing.along_m(half_s + 0.1) == Approx(0.05));
  CHECK(timing.along_m(half_s + 1.9) == Approx(0.05));
  CHECK(timing.along_m(half_s + 2.5) > 0.051);
}

TEST_CASE("Neither speed nor acceleration nor what an arc asks for is ever exceeded") {
  const Path path({at(0.2, 0.0),
                   at(0.21, 0.0),
                   {{{0.22, 0.01}, 0.0},
                    Eigen::Vector2d(0.21 + 0.01 * std::sqrt(0.5), 0.01 - 0.01 * std::sqrt(0.5))},
                   at(0.22, 0.012),
                   at(0.4, 0.012)});
  const double speed = 0.05, acceleration = PathTiming::kAcceleration_m_s2;
  const double arc_begin_m = path.segments()[0].length_m(),
               arc_end_m = arc_begin_m + path.segments()[1].length_m();
  const PathTiming timing(path, speed);
  CHECK(timing.along_m(timing.duration_s()) == Approx(path.length_m()));
  double last = 0.0, fastest = 0.0;
  for (double t_s = 0.001; t_s < timing.duration_s(); t_s += 0.001) {
    const double v = speed_at(timing, t_s);
    REQUIRE(v > -1e-9);
    REQUIRE(v < speed + 1e-9);
    REQUIRE(std::abs(v - last) < acceleration * 0.001 + 1e-9);
    const double along_m = timing.along_m(t_s);
    if (along_m > arc_begin_m && along_m < arc_end_m) REQUIRE(v * v / 0.01 < acceleration + 1e-6);
    last = v;
    fastest = std::max(fastest, v);
  }
  CHECK(fastest == Approx(speed));
}

TEST_CASE("A speed that is not positive is refused") {
  CHECK_THROWS_AS(PathTiming(Path({at(0.2, 0.0), at(0.3, 0.0)}), 0.0), std::invalid_argument);
  CHECK_THROWS_AS(PathTiming(Path({at(0.2, 0.0), at(0.3, 0.0)}), std::nan("")),
                  std::invalid_argument);
}

}  // namespace planar
