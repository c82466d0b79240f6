#include "planar_servo/health/arm_check.h"

#include <catch2/catch.hpp>
#include <functional>
#include <string>

#include "sample_arm.h"

namespace planar {
namespace {

using test::SoundCell;

constexpr double kNoise_m = 10e-6;

/// First moves from a bent arm: where it stands, then 40, 40 and 90 degrees of each motor. Each
/// pair of lamps is told in any order.
std::vector<ArmSight> first_moves(SoundCell& cell) {
  Eigen::Vector3d motors(cell.uniform(-kPi, kPi), cell.uniform(45.0, 100.0) * kDegree,
                         cell.uniform(-1.0, 1.0));
  std::vector<ArmSight> sights;
  for (int moved = -1; moved < 3; ++moved) {
    if (moved >= 0) motors[moved] += (moved == 2 ? 90.0 : 40.0) * kDegree;
    LampPlaces lamps = cell.see(motors, kNoise_m);
    if (moved % 2 == 0) std::swap(lamps[0], lamps[1]);
    sights.push_back({motors, lamps});
  }
  return sights;
}

struct ArmFault {
  Cause cause;
  std::function<void(CellModel&)> make;
  double size;  ///< NaN for faults in kind
};

const double kNoSize = std::nan("");

const ArmFault kArmFaults[] = {
    {Cause::kDirection1, [](CellModel& m) { m.gears[0] = -1.0; }, kNoSize},
    {Cause::kDirection2, [](CellModel& m) { m.gears[1] = -1.0; }, kNoSize},
    {Cause::kDirection3, [](CellModel& m) { m.gears[2] = -1.0; }, kNoSize},
    {Cause::kCoupling2, [](CellModel& m) { m.coupling = test::coupling_of(false, true); }, kNoSize},
    {Cause::kCoupling3, [](CellModel& m) { m.coupling = test::coupling_of(true, false); }, kNoSize},
    {Cause::kPositiveRotation, [](CellModel& m) { m.sense = -1.0; }, kNoSize},
    {Cause::kLinksExchanged, [](CellModel& m) { std::swap(m.links_m[0], m.links_m[1]); }, kNoSize},
    {Cause::kPictureMirrored, [](CellModel& m) { m.mirrored = true; }, kNoSize},
    {Cause::kGear1, [](CellModel& m) { m.gears[0] = 1.005; }, 1.005},
    {Cause::kGear2, [](CellModel& m) { m.gears[1] = 0.995; }, 0.995},
    {Cause::kGear3, [](CellModel& m) { m.gears[2] = 1.005; }, 1.005},
    {Cause::kGear1, [](CellModel& m) { m.gears[0] = 2.0; }, 2.0},
    {Cause::kZero1, [](CellModel& m) { m.zeros_rad[0] = 90.0 * kDegree; }, 90.0},
    {Cause::kZero2, [](CellModel& m) { m.zeros_rad[1] = 5.0 * kDegree; }, 5.0},
    {Cause::kZero3, [](CellModel& m) { m.zeros_rad[2] = -10.0 * kDegree; }, -10.0},
    {Cause::kLink1, [](CellModel& m) { m.links_m[0] += 4e-3; }, 4.0},
    {Cause::kLink2, [](CellModel& m) { m.links_m[1] -= 4e-3; }, -4.0},
    {Cause::kCameraShifted,
     [](CellModel& m) {
       m.shift_m = {40e-3, 30e-3};
     },
     50.0},
};

}  // namespace

TEST_CASE("Of 1,000 sound cells at most one has a fault in its first moves") {
  int alarms = 0;
  for (unsigned seed = 1; seed <= 1000; ++seed) {
    SoundCell cell(seed);
    if (find_arm_fault(test::filed_cell(), first_moves(cell))) ++alarms;
  }
  CHECK(alarms <= 1);
}

TEST_CASE("The first moves name what is wrong with an arm, and how much") {
  for (const ArmFault& fault : kArmFaults) {
    int seen = 0, named = 0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      SoundCell cell(seed);
      fault.make(cell.model);
      const auto found = find_arm_fault(test::filed_cell(), first_moves(cell));
      INFO(words(fault.cause) << ", seed " << seed << ": " << (found ? found->what : "nothing"));
      if (!found) continue;
      ++seen;
      if (found->cause != fault.cause) continue;
      ++named;
      if (std::isfinite(fault.size)) CHECK(found->size == Approx(fault.size).epsilon(0.25));
    }
    INFO(words(fault.cause));
    CHECK(seen >= 9);
    CHECK(named >= 8);
  }
}

TEST_CASE("Degrees taken for radians are named as a gear ratio") {
  SoundCell cell(3);
  cell.model.gears[2] = kDegree;
  const auto found = find_arm_fault(test::filed_cell(), first_moves(cell));
  REQUIRE(found);
  CHECK(found->cause == Cause::kGear3);
}

}  // namespace planar
