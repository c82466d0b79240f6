#include "planar_servo/loop/servo/path/path_follower.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/loop/servo/path/path_follower.h"
#include "support/robot_bench.h"

namespace planar {
namespace {

/// Three motors that each turn back a tremble, 3e-5 rad, later than wanted, and a step of 1 ms.
constexpr double kTurnsBackLate_rad = 1.2e-4;

}  // namespace

TEST_CASE("Joints commanded through a known play come out as wanted, to and fro") {
  const Transmission transmission(test::transmission_settings());
  const Eigen::Vector3d play(1.0e-3, 2.0e-3, 0.5e-3);
  GearPlay plan(transmission, play, {0.0, 0.0, 0.0}), gear(transmission, play, {0.0, 0.0, 0.0});
  double worst = 0.0;
  for (double t = 0.0; t < 12.0; t += 0.001) {
    const Joints wanted(0.2 * std::sin(t), 0.3 * std::sin(1.3 * t), 0.1 * std::sin(0.7 * t));
    const Joints out = gear.behind(plan.command(wanted));
    worst = std::max(worst, (out - wanted).cwiseAbs().maxCoeff());
  }
  CHECK(worst < kTurnsBackLate_rad);
}

TEST_CASE("Without a correction for play, joints that turn back lag by it") {
  const Transmission transmission(test::transmission_settings());
  GearPlay gear(transmission, {1.0e-3, 0.0, 0.0}, {0.0, 0.0, 0.0});
  CHECK(gear.behind({0.1, 0.1, 0.1})[0] == Approx(0.1));
  CHECK(gear.behind({0.0995, 0.0995, 0.0995})[0] == Approx(0.1));
  CHECK(gear.behind({0.09, 0.09, 0.09})[0] == Approx(0.091));
}

TEST_CASE("A motor that trembles is not led through its play") {
  const Transmission transmission(test::transmission_settings());
  GearPlay plan(transmission, {1.0e-3, 0.0, 0.0}, {0.0, 0.0, 0.0});
  CHECK(plan.command({0.1, 0.1, 0.1})[0] == Approx(0.1));
  CHECK(plan.command({0.09998, 0.1, 0.1})[0] == Approx(0.09998));
  CHECK(plan.command({0.0999, 0.1, 0.1})[0] == Approx(0.0989));
}

TEST_CASE("Between two samples joints are taken from the straight line, outside from the nearest") {
  JointHistory history;
  CHECK_THROWS_AS(history.at(0.0), std::logic_error);
  history.add(1.0, {0.0, 1.0, 2.0});
  history.add(1.5, {1.0, 1.0, 0.0});
  CHECK((history.at(1.25) - Joints(0.5, 1.0, 1.0)).norm() < 1e-12);
  CHECK(history.at(0.0) == Joints(0.0, 1.0, 2.0));
  CHECK(history.at(9.0) == Joints(1.0, 1.0, 0.0));
  history.add(9.0, {3.0, 3.0, 3.0});
  CHECK(history.at(1.5) == Joints(3.0, 3.0, 3.0));
}

}  // namespace planar
