#include "planar_servo/work/run/dry_run.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/units.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

const Workspace kWideRing{60.0 * kMillimetre, 590.0 * kMillimetre, {}};
const Workspace kWideDisc{0.0, 590.0 * kMillimetre, {}};

/// Returns targets at places that are written as these numbers, and with these directions.
std::vector<TargetRow> written_targets(double x, double y, const std::vector<double>& phi_deg) {
  std::vector<TargetRow> targets;
  for (const double phi : phi_deg)
    targets.push_back(
        {std::to_string(targets.size()), Eigen::Vector2d(x, y) * kMillimetre, phi * kDegree});
  return targets;
}

TEST_CASE("Targets in metres are refused where none can be reached, and questioned elsewhere") {
  const auto targets = written_targets(0.2, -0.35, {0.0, 90.0});
  for (const char* name : {"t.csv: ", "0.35 mm"})
    CHECK_THROWS_MATCHES(question_targets(targets, kWideRing, "t.csv"), InputError,
                         Refused(Cause::kContradiction, name));
  CHECK_NOTHROW(question_targets(targets, kWideDisc, "t.csv"));
  CHECK(target_doubts(targets, kWideDisc).size() == 1);
  auto mixed = targets;
  mixed.push_back({"far", {0.2, 0.1}, {}});
  CHECK(target_doubts(mixed, kWideRing).empty());
}

TEST_CASE("Targets on a work are questioned where its drawing is larger by far") {
  FoundWork work;
  work.fiducials.resize(2);
  work.fiducials[1].fiducial.p_W = {0.1, 0.0};
  const auto doubt = doubt_on_work(written_targets(0.02, 0.04, {0.0}), work);
  REQUIRE(doubt);
  CHECK_THAT(doubt->fault, Catch::Contains("0.04 mm") && Catch::Contains("100 mm"));
  CHECK_FALSE(doubt_on_work(written_targets(20.0, 0.04, {0.0}), work));
}

TEST_CASE("Directions that look like radians are questioned, and hold nothing up") {
  const auto targets = written_targets(200.0, 100.0, {1.5708, -3.1416, 0.0});
  const std::vector<Refusal> doubts = target_doubts(targets, kWideRing);
  REQUIRE(doubts.size() == 1);
  CHECK(doubts[0].cause == Cause::kContradiction);
  CHECK_THAT(doubts[0].fault, Catch::Contains("phi_deg is at most 3.1416"));
  CHECK_NOTHROW(question_targets(targets, kWideRing, "t.csv"));
  CHECK_NOTHROW(question_targets(written_targets(900.0, 0.0, {1.5}), kWideRing, "t.csv"));
}

TEST_CASE("Directions that degrees would be as well are not questioned") {
  for (const std::vector<double>& phi_deg :
       {std::vector<double>{1.5, 6.5}, {1.0, 2.0, -3.0}, {0.0, 0.0}})
    CHECK(target_doubts(written_targets(200.0, 100.0, phi_deg), kWideRing).empty());
  CHECK(target_doubts({{"a", {0.2, 0.1}, {}}}, kWideRing).empty());
  CHECK(target_doubts({}, kWideRing).empty());
}

}  // namespace
}  // namespace planar
