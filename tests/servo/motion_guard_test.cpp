#include "planar_servo/loop/servo/motion_guard.h"

#include <catch2/catch.hpp>
#include <functional>
#include <limits>

namespace planar {
namespace {

/// A look 0.3 mm and 0.1 deg away from its command, as a sound cell gives it.
GuardedLook sound_look() {
  GuardedLook look;
  look.commanded = {{0.2, 0.1}, 0.5};
  look.measurement.tip = {{0.2003, 0.1}, 0.5 + 0.1 * kDegree};
  look.measurement.lamps_B = {Eigen::Vector2d(0.18, 0.1), Eigen::Vector2d(0.22, 0.1)};
  look.measurement.frames = 4;
  look.measurement.noise_m = 1e-6;
  look.measurement.correction = {0.1e-3, 0.0};
  look.measurement.t_s = 12.2;
  look.arrived_s = 12.0;
  return look;
}

GuardLimits narrow_limits() {
  GuardLimits limits;
  limits.distance_m = 1e-3;
  limits.turn = 0.5 * kDegree;
  limits.separation_m = 40e-3;
  limits.separation_tolerance_m = 0.1e-3;
  limits.correction_m = 0.2e-3;
  return limits;
}

struct Fault {
  Cause cause;
  const char* size;
  bool of_cell;
  std::function<void(TipMeasurement&)> make;
};

const Fault kFaults[] = {
    {Cause::kInsufficient, "0.100 s", false, [](TipMeasurement& m) { m.t_s = 11.9; }},
    {Cause::kInsufficient, "0.060 mm", false, [](TipMeasurement& m) { m.noise_m = 30e-6; }},
    {Cause::kContradiction, "40.200 mm", true,
     [](TipMeasurement& m) { m.lamps_B[1].x() += 0.2e-3; }},
    {Cause::kContradiction, "50.30 mm", true, [](TipMeasurement& m) { m.tip.p.x() += 50e-3; }},
    {Cause::kContradiction, "75.10 deg", true,
     [](TipMeasurement& m) { m.tip.phi += 75.0 * kDegree; }},
    {Cause::kInsufficient, "0.250 mm", false,
     [](TipMeasurement& m) {
       m.correction = {0.0, -0.25e-3};
     }},
};

}  // namespace

TEST_CASE("A look that agrees with its command and its cell is not doubted") {
  const GuardedLook look = sound_look();
  CHECK_FALSE(doubt(narrow_limits(), look, nullptr));
  CHECK_FALSE(doubt(narrow_limits(), look, &look));
}

TEST_CASE("Each fault of a look is doubted by its cause and its size") {
  for (const Fault& fault : kFaults) {
    GuardedLook look = sound_look();
    fault.make(look.measurement);
    const auto found = doubt(narrow_limits(), look, nullptr);
    REQUIRE(found);
    CHECK(found->cause == fault.cause);
    CHECK_THAT(found->fault, Catch::Contains(fault.size));
    CHECK(found->of_cell == fault.of_cell);
  }
}

TEST_CASE("A look of which a number is unknown is doubted") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::function<void(TipMeasurement&)> unknowns[] = {
      [&](TipMeasurement& m) { m.t_s = nan; },
      [&](TipMeasurement& m) { m.noise_m = nan; },
      [&](TipMeasurement& m) { m.lamps_B[0].x() = nan; },
      [&](TipMeasurement& m) { m.tip.p.y() = nan; },
      [&](TipMeasurement& m) { m.tip.phi = nan; },
      [&](TipMeasurement& m) { m.correction.x() = nan; }};
  for (const auto& make : unknowns) {
    GuardedLook look = sound_look();
    make(look.measurement);
    CHECK(doubt(narrow_limits(), look, nullptr));
  }
}

TEST_CASE("Errors diverge that grow in each of the last two looks, and by more than the noise") {
  constexpr double kNoise = 0.5;
  CHECK(diverges({1.0, 2.0, 3.0}, kNoise));
  CHECK(diverges({9.0, 1.0, 2.0, 3.0}, kNoise));
  CHECK_FALSE(diverges({1.0, 2.0}, kNoise));
  CHECK_FALSE(diverges({2.0, 1.0, 4.0}, kNoise));
  CHECK_FALSE(diverges({1.0, 5.0, 4.0}, kNoise));
  CHECK_FALSE(diverges({1.0, 1.2, 1.4}, kNoise));
  CHECK_FALSE(diverges({1.0, 2.0, 2.0}, kNoise));
  CHECK_FALSE(diverges({1.0, 1.0, 2.0}, kNoise));
  CHECK_FALSE(diverges({1.0, 1.25, 1.5}, kNoise));
}

TEST_CASE("A turn by nearly a whole turn is a small one") {
  GuardedLook look = sound_look();
  look.measurement.tip.phi += 2.0 * kPi - 0.2 * kDegree;
  CHECK_FALSE(doubt(narrow_limits(), look, nullptr));
}

TEST_CASE("A light that does not follow the command is doubted, a motion with play is not") {
  const GuardedLook before = sound_look();
  GuardedLook look = before;
  look.commanded.p.x() += 1e-3;
  const auto still = doubt(narrow_limits(), look, &before);
  REQUIRE(still);
  CHECK(still->of_cell);
  CHECK(still->cause == Cause::kContradiction);
  CHECK_THAT(still->text(), Catch::Contains("by 1.000 mm"));
  look.measurement.tip.p.x() += 0.95e-3;  // 0.05 mm of play
  CHECK_FALSE(doubt(narrow_limits(), look, &before));
}

TEST_CASE("The longer the way, the more it may differ from the command") {
  const GuardedLook before = sound_look();
  GuardedLook look = before;
  look.commanded.p.x() += 5e-3;
  look.measurement.tip.p.x() += 4.5e-3;
  CHECK_FALSE(doubt(narrow_limits(), look, &before));
  look.measurement.tip.p.x() -= 0.2e-3;
  CHECK(doubt(narrow_limits(), look, &before));
}

TEST_CASE("Without a calibration's word a cell still promises 10 mm and 3 degrees") {
  GuardedLook look = sound_look();
  look.measurement.tip.p.y() += 9e-3;
  look.measurement.tip.phi += 2.8 * kDegree;
  CHECK_FALSE(doubt(GuardLimits(), look, nullptr));
  look.measurement.tip.p.y() += 2e-3;
  CHECK(doubt(GuardLimits(), look, nullptr));
}

}  // namespace planar
