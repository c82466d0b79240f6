#include "planar_servo/loop/health/health_check.h"

#include <catch2/catch.hpp>
#include <functional>
#include <string>

#include "planar_servo/base/core/pose.h"
#include "sample_arm.h"

namespace planar {
namespace {

using test::SoundCell;

constexpr double kNoise_m = 10e-6;

/// First moves from a bent arm: where it stands, then 40, 40 and 60 degrees of each motor. Each
/// pair of lamps is told in any order.
std::vector<ArmSight> first_moves(SoundCell& cell) {
  Eigen::Vector3d motors(cell.uniform(-kPi, kPi), cell.uniform(45.0, 100.0) * kDegree,
                         cell.uniform(-1.0, 1.0));
  std::vector<ArmSight> sights;
  for (int moved = -1; moved < 3; ++moved) {
    if (moved >= 0) motors[moved] += (moved == 2 ? 60.0 : 40.0) * kDegree;
    LampPlaces lamps = cell.see(motors, kNoise_m);
    if (moved % 2 == 0) std::swap(lamps[0], lamps[1]);
    sights.push_back({motors, lamps});
  }
  return sights;
}

struct ArmFault {
  HealthCause cause;
  std::function<void(SoundCell&)> make;
  double size;  ///< NaN for faults in kind
};

const double kNoSize = std::nan("");

std::function<void(SoundCell&)> off_by(int number, double value) {
  return [=](SoundCell& cell) { cell.off[number] = value; };
}

std::function<void(SoundCell&)> built(const std::function<void(CellModel&)>& make) {
  return [=](SoundCell& cell) { make(cell.model); };
}

/// Lets two motors get each other's pulses: a radian of one is `gears` of the other.
std::function<void(SoundCell&)> exchanged(int one, int other, double gears) {
  return built([=](CellModel& model) {
    model.gears(one, one) = model.gears(other, other) = 0.0;
    model.gears(one, other) = gears;
    model.gears(other, one) = 1.0 / gears;
  });
}

const ArmFault kArmFaults[] = {
    {HealthCause::kExchanged12, exchanged(0, 1, -0.8), kNoSize},
    {HealthCause::kExchanged13, exchanged(0, 2, 1.0 / 1.5), kNoSize},
    {HealthCause::kExchanged23, exchanged(1, 2, -1.0 / 1.2), kNoSize},
    {HealthCause::kDirection1, built([](CellModel& m) { m.gears(0, 0) = -1.0; }), kNoSize},
    {HealthCause::kDirection2, built([](CellModel& m) { m.gears(1, 1) = -1.0; }), kNoSize},
    {HealthCause::kDirection3, built([](CellModel& m) { m.gears(2, 2) = -1.0; }), kNoSize},
    {HealthCause::kCoupling2,
     built([](CellModel& m) { m.coupling = test::coupling_of(false, true); }), kNoSize},
    {HealthCause::kCoupling3,
     built([](CellModel& m) { m.coupling = test::coupling_of(true, false); }), kNoSize},
    {HealthCause::kPositiveRotation, built([](CellModel& m) { m.sense = -1.0; }), kNoSize},
    {HealthCause::kLinksExchanged, built([](CellModel& m) { m.links_m.reverseInPlace(); }),
     kNoSize},
    {HealthCause::kPictureMirrored, built([](CellModel& m) { m.mirrored = true; }), kNoSize},
    {HealthCause::kUneven1, off_by(kGearOff, 0.005), 1.005},
    {HealthCause::kUneven2, off_by(kGearOff + 1, -0.006), 0.994},
    {HealthCause::kUneven3, off_by(kGearOff + 2, 0.006), 1.006},
    {HealthCause::kGear1, off_by(kGearOff, 1.0), 2.0},
    {HealthCause::kZero1, off_by(kZeroOff, 90.0 * kDegree), 90.0},
    {HealthCause::kZero2, off_by(kZeroOff + 1, 5.0 * kDegree), 5.0},
    {HealthCause::kZero3, off_by(kZeroOff + 2, -10.0 * kDegree), -10.0},
    {HealthCause::kLink1, off_by(kLinkOff, 4e-3), 4.0},
    {HealthCause::kLink2, off_by(kLinkOff + 1, -5e-3), -5.0},
    {HealthCause::kLamp1Moved, off_by(kLampOff + 1, 1e-3), 1.0},
    {HealthCause::kGear2, off_by(kGearOff + 1, 0.5), 1.5},
    {HealthCause::kCameraShifted, off_by(kShiftOff, 50e-3), 50.0},
    {HealthCause::kCameraShifted, off_by(kShiftOff, 150e-3), 150.0},
    {HealthCause::kCameraTurned, off_by(kTurnOff, 90.0 * kDegree), 90.0},
    {HealthCause::kCameraCloser, off_by(kGrowthOff, 0.05), 5.0},
    {HealthCause::kElbow,
     [](SoundCell& cell) {
       SoundCell same_cell = cell;  // which draws the same moves
       const CellModel filed = test::filed_cell();
       const Eigen::Vector3d theta =
           filed.coupling.inverse() * first_moves(same_cell).front().motors;
       const Eigen::Vector2d tip =
           rotation2d(theta[0]).col(0) * 0.3 + rotation2d(theta[1]).col(0) * 0.25;
       const double ray = std::atan2(tip.y(), tip.x());
       cell.model.zeros +=
           filed.coupling * Eigen::Vector3d(2.0 * (ray - theta[0]), 2.0 * (ray - theta[1]), 0.0);
     },
     kNoSize},
};

}  // namespace

TEST_CASE("Of 300 sound cells at most one has a fault in its first moves") {
  int alarms = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SoundCell cell(seed);
    if (!find_arm_faults(test::filed_cell(), first_moves(cell)).empty()) ++alarms;
  }
  CHECK(alarms <= 1);
}

TEST_CASE("The first moves name what is wrong with an arm, and how much") {
  for (const ArmFault& fault : kArmFaults) {
    int seen = 0, named = 0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      SoundCell cell(seed);
      fault.make(cell);
      const auto found = find_arm_faults(test::filed_cell(), first_moves(cell));
      INFO(words(fault.cause) << ", seed " << seed << ": "
                              << (found.empty() ? "nothing" : found[0].fault));
      if (found.empty()) continue;
      ++seen;
      UNSCOPED_INFO(words(fault.cause) << ", seed " << seed << ": " << found[0].fault);
      if (found[0].what != fault.cause) continue;
      ++named;
      if (std::isfinite(fault.size)) CHECK(found[0].size == Approx(fault.size).epsilon(0.25));
    }
    INFO(words(fault.cause));
    CHECK(seen >= 9);
    CHECK(named >= 8);
  }
}

TEST_CASE("Drives that are exchanged are named with what to exchange, also after homing by sight") {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SoundCell cell(seed), same_cell(seed);
    const bool is_alike = seed % 2 == 0;
    CellModel filed = test::filed_cell();
    if (is_alike) filed.pulses_per_rad.setConstant(-1e5);
    exchanged(0, 1, is_alike ? 1.0 : -0.8)(cell);
    cell.model.home = first_moves(same_cell).front().motors;
    const auto found = find_arm_faults(filed, first_moves(cell));
    REQUIRE(found.size() == 1);
    CHECK(found[0].fault == "the drives of joints 1 and 2 are exchanged");
    CHECK_THAT(found[0].remedy, Catch::Contains("order of its counts"));
  }
}

TEST_CASE("A joint that turns the other way is named also after homing by sight") {
  SoundCell cell(3), same_cell(3);
  cell.model.gears(0, 0) = -1.0;
  cell.model.home = first_moves(same_cell).front().motors;
  const auto found = find_arm_faults(test::filed_cell(), first_moves(cell));
  REQUIRE(found.size() == 1);
  CHECK(found[0].what == HealthCause::kDirection1);
}

TEST_CASE("No gear is said to turn a joint as far as none does") {
  SoundCell cell(3);
  cell.model.gears(2, 2) = 44.0;
  const auto found = find_arm_faults(test::filed_cell(), first_moves(cell));
  REQUIRE_FALSE(found.empty());
  // Two turns as far look alike where 42 more end at the same direction.
  CHECK((found[0].what != HealthCause::kGear3 || found[0].size <= 30.0));
}

TEST_CASE("Degrees taken for radians are named as a gear ratio") {
  SoundCell cell(3);
  cell.model.gears(2, 2) = kDegree;
  const auto found = find_arm_faults(test::filed_cell(), first_moves(cell));
  REQUIRE_FALSE(found.empty());
  CHECK(found[0].what == HealthCause::kGear3);
}

}  // namespace planar
