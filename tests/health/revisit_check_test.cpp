#include "planar_servo/health/revisit_check.h"

#include <catch2/catch.hpp>
#include <functional>

#include "sample_arm.h"

namespace planar {
namespace {

using test::SoundCell;

constexpr double kLookNoise_m = 3e-6;

/// Four places about the base, one of them with the tool turned.
const Eigen::Vector3d kPlaces[] = {
    {0.3, 1.4, -1.7}, {1.9, 1.1, -2.9}, {-2.6, 1.8, 0.8}, {-1.0, 0.9, 1.7}};

/// Visits the places of a cell before and after `make` has changed it.
std::vector<Revisit> visit_twice(unsigned seed, const std::function<void(CellModel&)>& make) {
  SoundCell cell(seed);
  std::vector<Revisit> revisits;
  for (const Eigen::Vector3d& motors : kPlaces)
    revisits.push_back({motors, cell.see(motors, kLookNoise_m), {}, std::sqrt(2.0) * kLookNoise_m});
  make(cell.model);
  for (Revisit& revisit : revisits) revisit.now_B = cell.see(revisit.motors, kLookNoise_m);
  return revisits;
}

struct MovedThing {
  Cause cause;
  std::function<void(CellModel&)> make;
  double size;
};

const MovedThing kMoved[] = {
    {Cause::kCameraShifted,
     [](CellModel& m) {
       m.shift_m = {0.6e-3, -0.8e-3};
     },
     1.0},
    {Cause::kCameraShifted,
     [](CellModel& m) {
       m.shift_m = {20e-6, 0.0};
     },
     0.02},
    {Cause::kCameraTurned, [](CellModel& m) { m.turn = 0.1 * kDegree; }, 0.1},
    {Cause::kCameraCloser, [](CellModel& m) { m.growth = -1.3e-3; }, -0.13},
    {Cause::kLamp1Moved, [](CellModel& m) { m.lamps_T[0].x() += 1e-3; }, 1.0},
    {Cause::kLamp1Moved, [](CellModel& m) { m.lamps_T[0].y() += 40e-6; }, 0.04},
    {Cause::kLamp2Moved, [](CellModel& m) { m.lamps_T[1].y() -= 0.2e-3; }, 0.2},
    {Cause::kZero2, [](CellModel& m) { m.zeros_rad[1] += 0.05 * kDegree; }, 0.05},
    {Cause::kZero3, [](CellModel& m) { m.zeros_rad[2] -= 0.3 * kDegree; }, -0.3},
};

}  // namespace

TEST_CASE("Of 2,000 unchanged cells at most ten are found changed") {
  int alarms = 0;
  for (unsigned seed = 1; seed <= 2000; ++seed)
    if (!find_changes(test::filed_cell(), visit_twice(seed, [](CellModel&) {})).empty()) ++alarms;
  CHECK(alarms <= 10);
}

TEST_CASE("Revisits name what has moved, and by how much") {
  for (const MovedThing& moved : kMoved) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const auto found = find_changes(test::filed_cell(), visit_twice(seed, moved.make));
      INFO(words(moved.cause) << ", seed " << seed << (found.empty() ? "" : found[0].what));
      REQUIRE_FALSE(found.empty());
      CHECK(found[0].cause == moved.cause);
      CHECK(found[0].size == Approx(moved.size).epsilon(0.3));
    }
  }
}

TEST_CASE("A turn about the base is either the camera or joint 1, and both are named") {
  CellModel above_base = test::filed_cell();
  above_base.foot_B.setZero();
  const auto found =
      find_changes(above_base, visit_twice(1, [](CellModel& m) { m.zeros_rad[0] += 1e-3; }));
  REQUIRE(found.size() == 2);
  for (const HealthFinding& one : found)
    CHECK((one.cause == Cause::kZero1 || one.cause == Cause::kCameraTurned));
}

TEST_CASE("Two things at once are not called one") {
  const auto found = find_changes(test::filed_cell(), visit_twice(1, [](CellModel& m) {
                                    m.lamps_T[0].x() += 1e-3;
                                    m.turn = 0.2 * kDegree;
                                  }));
  REQUIRE(found.size() == 1);
  CHECK(found[0].cause == Cause::kSeveral);
  CHECK(found[0].cost_m > 0.5e-3);
}

TEST_CASE("A change that costs less than 0.01 mm is no finding") {
  CHECK(find_changes(test::filed_cell(), visit_twice(1,
                                                     [](CellModel& m) {
                                                       m.shift_m = {1e-6, 0.0};
                                                     }))
            .empty());
}

}  // namespace planar
