#include "planar_servo/virtual_cell/virtual_drive.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace planar {
namespace {

constexpr MotionLimits kLimits{1000.0, 500.0};
constexpr double kAlgebra = 1e-9;  // positions up to 1e4, a few operations in double

}  // namespace

TEST_CASE("A long move takes distance over speed plus one ramp") {
  const MotionProfile profile(2.0, {100.0, 0.0}, 10100.0, kLimits);
  CHECK(profile.end_s() == Approx(2.0 + 10.0 + 2.0));
  CHECK(profile.state_at(8.0).position == Approx(5100.0));
  CHECK(profile.state_at(8.0).velocity == Approx(1000.0));
  CHECK(profile.state_at(3.0).position == Approx(100.0 + 0.5 * 500.0));
  CHECK(profile.state_at(1.0).position == Approx(100.0));
  CHECK(profile.state_at(99.0).position == 10100.0);
}

TEST_CASE("A short move is a triangle of twice the root of distance over acceleration") {
  const MotionProfile profile(0.0, {0.0, 0.0}, -200.0, kLimits);
  CHECK(profile.end_s() == Approx(2.0 * std::sqrt(200.0 / 500.0)));
  CHECK(profile.state_at(0.5 * profile.end_s()).position == Approx(-100.0));
}

TEST_CASE("A move to where the motor stands ends at once") {
  CHECK(MotionProfile(3.0, {7.0, 0.0}, 7.0, kLimits).end_s() == 3.0);
}

TEST_CASE("A target behind a moving motor is reached after a stop beyond it") {
  const MotionProfile profile(0.0, {0.0, 1000.0}, 0.0, kLimits);  // stops 1000 further on
  CHECK(profile.end_s() == Approx(2.0 + 2.0 * std::sqrt(1000.0 / 500.0)));
  CHECK(profile.state_at(2.0).position == Approx(1000.0));
  CHECK(profile.state_at(2.0).velocity == Approx(0.0).margin(kAlgebra));
  CHECK(profile.state_at(profile.end_s()).position == 0.0);
  const auto turns = profile.turning_points(0.0, 2.5);
  REQUIRE_FALSE(turns.empty());
  CHECK(turns.front() == Approx(1000.0));
}

TEST_CASE("A moving start keeps within the limits and is continuous") {
  for (const double velocity : {-900.0, -300.0, 0.0, 400.0, 1000.0, 1400.0})
    for (const double target : {-4000.0, -10.0, 0.0, 300.0, 900.0, 5000.0}) {
      const MotionProfile profile(0.0, {0.0, velocity}, target, kLimits);
      constexpr double kStep = 1e-3;
      MotionState last = profile.state_at(0.0);
      CHECK(last.velocity == Approx(velocity).margin(target == 0.0 ? 1e-6 : kAlgebra));
      bool bounded = true;
      for (double t = kStep; t < profile.end_s() + 1.0; t += kStep) {
        const MotionState now = profile.state_at(t);
        bounded = bounded && std::abs(now.velocity - last.velocity) < 500.0 * kStep * 1.001 &&
                  std::abs(now.position - last.position) < 1400.0 * kStep * 1.001;
        last = now;
      }
      CHECK(bounded);
      CHECK(last.position == target);
    }
}

}  // namespace planar
