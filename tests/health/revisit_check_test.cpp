#include "planar_servo/loop/health/health_check.h"

#include <catch2/catch.hpp>
#include <random>

#include "planar_servo/base/core/pose.h"
#include "sample_arm.h"

namespace planar {
namespace {

using test::SoundCell;

constexpr double kLookNoise_m = 3e-6;

/// Four places about the base, one of them with the tool turned.
const Eigen::Vector3d kPlaces[] = {
    {0.3, 1.4, -1.7}, {1.9, 1.1, -2.9}, {-2.6, 1.8, 0.8}, {-1.0, 0.9, 1.7}};

/// Visits the places of a cell before and after these numbers have changed.
std::vector<Revisit> visit_twice(unsigned seed, const Numbers& off) {
  SoundCell cell(seed);
  std::vector<Revisit> revisits;
  for (const Eigen::Vector3d& motors : kPlaces)
    revisits.push_back({motors, cell.see(motors, kLookNoise_m), {}, std::sqrt(2.0) * kLookNoise_m});
  cell.off = off;
  for (Revisit& revisit : revisits) revisit.now_B = cell.see(revisit.motors, kLookNoise_m);
  return revisits;
}

struct MovedThing {
  HealthCause cause;
  int number;
  double value;
  double size;
};

const MovedThing kMoved[] = {
    {HealthCause::kCameraShifted, kShiftOff, 1e-3, 1.0},
    {HealthCause::kCameraShifted, kShiftOff + 1, 20e-6, 0.02},
    {HealthCause::kCameraTurned, kTurnOff, 0.1 * kDegree, 0.1},
    {HealthCause::kCameraCloser, kGrowthOff, -1.3e-3, -0.13},
    {HealthCause::kCameraTilted, kTiltOff, 1e-3, 0.25},
    {HealthCause::kLamp1Moved, kLampOff, 1e-3, 1.0},
    {HealthCause::kLamp1Moved, kLampOff + 1, 40e-6, 0.04},
    {HealthCause::kLamp2Moved, kLampOff + 3, -0.2e-3, 0.2},
    {HealthCause::kZero2, kZeroOff + 1, 0.05 * kDegree, 0.05},
    {HealthCause::kZero3, kZeroOff + 2, -0.3 * kDegree, -0.3},
    {HealthCause::kUneven2, kGearOff + 1, 0.002, 1.002},
    {HealthCause::kLink1, kLinkOff, 0.5e-3, 0.5},
};

}  // namespace

TEST_CASE("Of 2,000 unchanged cells at most ten are found changed") {
  int alarms = 0;
  for (unsigned seed = 1; seed <= 2000; ++seed)
    if (!find_changes(test::filed_cell(), visit_twice(seed, Numbers::Zero())).empty()) ++alarms;
  CHECK(alarms <= 10);
}

TEST_CASE("Revisits name what has moved, and by how much") {
  for (const MovedThing& moved : kMoved) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const auto found = find_changes(test::filed_cell(),
                                      visit_twice(seed, moved.value * Numbers::Unit(moved.number)));
      INFO(words(moved.cause) << ", seed " << seed << (found.empty() ? "" : found[0].fault));
      REQUIRE_FALSE(found.empty());
      CHECK(found[0].what == moved.cause);
      CHECK(found[0].size == Approx(moved.size).epsilon(0.3));
    }
  }
}

TEST_CASE("A turn about the base is either the camera or joint 1, and both are named") {
  CellModel above_base = test::filed_cell();
  above_base.axis_B.setZero();
  const auto found = find_changes(above_base, visit_twice(1, 1e-3 * Numbers::Unit(kZeroOff)));
  REQUIRE(found.size() == 2);
  for (const HealthFinding& one : found)
    CHECK((one.what == HealthCause::kZero1 || one.what == HealthCause::kCameraTurned));
}

TEST_CASE("One place alone that is off is a stray, and a change that moves all of them is not") {
  int strays = 0, of_sound = 0, of_moved = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    auto sound = visit_twice(seed, Numbers::Zero());
    of_sound += stray_place(test::filed_cell(), sound) ? 1 : 0;
    for (Eigen::Vector2d& lamp : sound[seed % 4].now_B) lamp += Eigen::Vector2d(1e-3, -2e-3);
    strays += stray_place(test::filed_cell(), sound) == seed % 4 ? 1 : 0;
    for (const MovedThing& moved : kMoved)
      of_moved += stray_place(test::filed_cell(),
                              visit_twice(seed, moved.value * Numbers::Unit(moved.number)))
                      ? 1
                      : 0;
  }
  CHECK(strays >= 198);
  CHECK(of_sound <= 1);
  CHECK(of_moved == 0);
}

TEST_CASE("The place that a drift has displaced farthest is no stray") {
  constexpr double kStep_m = 8e-6;  // from place to place
  int strays = 0, found = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::vector<Revisit> revisits;
    SoundCell cell(seed);
    for (const Eigen::Vector3d& motors : kPlaces)
      revisits.push_back(
          {motors, cell.see(motors, kLookNoise_m), {}, std::sqrt(2.0) * kLookNoise_m});
    for (std::size_t i = 0; i < revisits.size(); ++i) {  // the last two twice
      constexpr double kSteps[] = {4.0, 5.0, 8.0, 9.0}, kBetweenTwo = 1.5;
      cell.off.segment<2>(kShiftOff) = kSteps[i] * kStep_m * rotation2d(seed).col(0);
      revisits[i].now_B = cell.see(revisits[i].motors, kLookNoise_m);
      revisits[i].scatter_m = kBetweenTwo * kStep_m;  // as which the drift shows at first
    }
    strays += stray_place(test::filed_cell(), revisits) ? 1 : 0;
    const auto changes = find_changes(test::filed_cell(), revisits);
    found += !changes.empty() && changes[0].what == HealthCause::kCameraShifted ? 1 : 0;
  }
  CHECK(strays <= 2);
  CHECK(found > 150);
}

/// Visits the places of a cell whose stops scatter by this, before and after a change.
std::vector<Revisit> visit_twice_scattered(unsigned seed, double scatter_m, const Numbers& off) {
  std::vector<Revisit> revisits = visit_twice(seed, off);
  SoundCell random(seed + 10000);
  for (Revisit& revisit : revisits) {
    revisit.scatter_m = scatter_m;
    for (LampPlaces* lamps : {&revisit.then_B, &revisit.now_B}) {
      const Eigen::Vector2d stop(random.normal(scatter_m), random.normal(scatter_m));
      for (Eigen::Vector2d& lamp : *lamps) lamp += stop;
    }
  }
  return revisits;
}

TEST_CASE(
    "The scatter of a sound arm is no finding where it is known, and is one where it is not") {
  constexpr double kScatter_m = 40e-6;
  int found = 0, found_unknown = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    auto revisits = visit_twice_scattered(seed, kScatter_m, Numbers::Zero());
    found += find_changes(test::filed_cell(), revisits).empty() ? 0 : 1;
    for (Revisit& revisit : revisits) revisit.scatter_m = 0.0;
    found_unknown += find_changes(test::filed_cell(), revisits).empty() ? 0 : 1;
  }
  CHECK(found <= 2);
  CHECK(found_unknown >= 198);
}

TEST_CASE("A base that moves is no finding where that is known, all places of a check alike") {
  constexpr double kWander_m = 8e-6;
  int found = 0, found_unknown = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    auto revisits = visit_twice(seed, Numbers::Zero());
    std::mt19937 random(seed);
    std::normal_distribution<double> base(0.0, kWander_m);
    const auto move = [&](LampPlaces& lamps_B, const Eigen::Vector2d& by_m) {
      for (Eigen::Vector2d& lamp : lamps_B) lamp += by_m;
    };
    const Eigen::Vector2d now_m{base(random), base(random)};
    for (Revisit& revisit : revisits) {
      revisit.wander_m = kWander_m;
      move(revisit.then_B, {base(random), base(random)});
      move(revisit.now_B, now_m);
    }
    found += find_changes(test::filed_cell(), revisits).empty() ? 0 : 1;
    for (Revisit& revisit : revisits) revisit.wander_m = 0.0;
    found_unknown += find_changes(test::filed_cell(), revisits).empty() ? 0 : 1;
  }
  CHECK(found <= 2);
  CHECK(found_unknown >= 100);
}

TEST_CASE("A camera raised by 2 mm is found through an arm's scatter") {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto found =
        find_changes(test::filed_cell(),
                     visit_twice_scattered(seed, 40e-6, -2e-3 / 1.5 * Numbers::Unit(kGrowthOff)));
    INFO("seed " << seed);
    REQUIRE_FALSE(found.empty());
    CHECK(found[0].what == HealthCause::kCameraCloser);
    CHECK(found[0].size == Approx(-0.133).epsilon(0.3));
  }
}

TEST_CASE("Links that warmth lets grow cost nothing, and a link that grows alone does") {
  const CellModel model = test::filed_cell();
  Numbers grown = Numbers::Zero();
  grown.segment<2>(kLinkOff) = 1e-4 * model.links_m;
  int warm = 0, costly = 0, alone = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const auto of_warm = find_changes(model, visit_twice(seed, grown));
    warm += !of_warm.empty() && of_warm[0].what == HealthCause::kWarmth;
    costly += !of_warm.empty() && of_warm[0].cost_m > 0.0;
    const auto of_one = find_changes(model, visit_twice(seed, 0.2e-3 * Numbers::Unit(kLinkOff)));
    alone += !of_one.empty() && of_one[0].cost_m > 0.0;
  }
  CHECK(warm > 50);  // where the tool is seen more than 0.05 mm off
  CHECK(costly <= 2);
  CHECK(alone == 100);
}

TEST_CASE("Two things at once are not called one") {
  const auto found = find_changes(
      test::filed_cell(),
      visit_twice(1, 1e-3 * Numbers::Unit(kLampOff) + 3.5e-3 * Numbers::Unit(kTurnOff)));
  REQUIRE(found.size() == 1);
  CHECK(found[0].what == HealthCause::kSeveral);
  CHECK(found[0].cost_m > 0.5e-3);
}

TEST_CASE("A change that costs less than 0.01 mm is no finding") {
  CHECK(find_changes(test::filed_cell(), visit_twice(1, 1e-6 * Numbers::Unit(kShiftOff))).empty());
}

TEST_CASE("Play beyond what is allowed is named by its joint, and usual play is not") {
  constexpr double kAllowed = 0.1 * kDegree;
  for (int motor = 0; motor < 3; ++motor) {
    std::vector<Revisit> twice = visit_twice(7, 0.15 * kDegree * Numbers::Unit(kZeroOff + motor));
    const auto found = find_play(test::filed_cell(), twice[0], kAllowed);
    REQUIRE(found.size() == 1);
    CHECK(static_cast<int>(found[0].what) == static_cast<int>(HealthCause::kPlay1) + motor);
    CHECK(found[0].size == Approx(0.15).epsilon(0.15));
    twice = visit_twice(8, 0.01 * kDegree * Numbers::Unit(kZeroOff + motor));
    CHECK(find_play(test::filed_cell(), twice[0], kAllowed).empty());
  }
}

}  // namespace planar
