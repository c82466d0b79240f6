#include "planar_servo/field/joint_estimate.h"

#include <catch2/catch.hpp>

#include "field/bent_cell.h"
#include "planar_servo/core/error.h"

namespace planar {
namespace {

TEST_CASE("As many harmonics are found as the reducers have") {
  for (const double second : {0.0, 0.25}) {
    test::BentCell cell;
    cell.second = second;
    std::mt19937 random(3);
    const JointEstimate found = estimate_jointly(cell.nominal(), cell.samples(60, 0, random));
    CHECK(found.size.harmonics == (second > 0.0 ? 2 : 1));
    CHECK(found.left_out.empty());
    CHECK(found.fit.arm[0] == Approx(cell.link1).margin(20e-6));
    CHECK(found.fit.arm[1] == Approx(cell.link2).margin(20e-6));
    const double sigma = std::sqrt(found.fit.covariance.diagonal()[2 * found.fit.basis.terms()]);
    CHECK(std::abs(found.fit.arm[0] - cell.link1) < 4.0 * sigma);
  }
}

TEST_CASE("A wrong reading leaves without its pose, a wrong lamp takes the pose with it") {
  const test::BentCell cell;
  std::mt19937 random(8);
  std::vector<PoseSample> samples = cell.samples(60, 0, random);
  samples[7].reflector_B->x() += 0.2e-3;
  samples[11].lamps_B[1].y() += 0.1e-3;
  const JointEstimate found = estimate_jointly(cell.nominal(), samples);
  REQUIRE(found.left_out.size() == 3);
  int readings_of_7 = 0, of_11 = 0;
  for (const JointOutlier& outlier : found.left_out) {
    readings_of_7 += outlier.index == 7 && outlier.reading ? 1 : 0;
    of_11 += outlier.index == 11 ? 1 : 0;
  }
  CHECK(readings_of_7 == 1);
  CHECK(of_11 == 2);
}

TEST_CASE("Too few poses are refused") {
  const test::BentCell cell;
  std::mt19937 random(9);
  std::vector<PoseSample> samples = cell.samples(40, 0, random);
  CHECK_THROWS_WITH(estimate_jointly(cell.nominal(), {samples.begin(), samples.begin() + 11}),
                    Catch::Contains("11 poses are too few"));
}

}  // namespace
}  // namespace planar
