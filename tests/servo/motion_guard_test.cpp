#include "planar_servo/loop/servo/motion_guard.h"

#include <catch2/catch.hpp>
#include <functional>

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
  const char* words;
  bool of_cell;
  std::function<void(TipMeasurement&)> cause;
};

const Fault kFaults[] = {
    {"0.100 s before the arm had come to rest", false, [](TipMeasurement& m) { m.t_s = 11.9; }},
    {"vision is uncertain by +- 0.060 mm; allowed is 0.050 mm", false,
     [](TipMeasurement& m) { m.noise_m = 30e-6; }},
    {"the lamps are seen 40.200 mm apart, but were 40.000 +- 0.100 mm apart", true,
     [](TipMeasurement& m) { m.lamps_B[1].x() += 0.2e-3; }},
    {"50.30 mm from where it was commanded, (200.000, 100.000) mm; this cell allows 1.00 mm", true,
     [](TipMeasurement& m) { m.tip.p.x() += 50e-3; }},
    {"seen turned by 75.10 deg from where it was commanded; this cell allows 0.50 deg", true,
     [](TipMeasurement& m) { m.tip.phi += 75.0 * kDegree; }},
    {"the error map would correct by 0.250 mm; within its region it never corrects by more than "
     "0.200 mm",
     false,
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

TEST_CASE("Each contradiction is doubted in its own words") {
  for (const Fault& fault : kFaults) {
    GuardedLook look = sound_look();
    fault.cause(look.measurement);
    const auto found = doubt(narrow_limits(), look, nullptr);
    REQUIRE(found);
    CHECK_THAT(found->text(), Catch::Contains(fault.words));
    CHECK(found->of_cell == fault.of_cell);
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
  CHECK_THAT(still->text(), Catch::Contains("they differ by 1.000 mm"));
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
