#include "planar_servo/offline/plan/proposed_plan.h"

#include <catch2/catch.hpp>

#include "field/bent_cell.h"

namespace planar {
namespace {

JointEstimate estimate_of(const test::BentCell& cell, const std::vector<PoseSample>& samples) {
  JointEstimate estimate;
  estimate.nominal = cell.nominal();
  estimate.fit = fit_jointly(estimate.model(), {}, samples, 0.6).value();
  return estimate;
}

TEST_CASE("Places are proposed where nothing was read, and what they promise comes out") {
  const test::BentCell cell;
  std::mt19937 random(61);
  std::vector<PoseSample> right;  // readings on one side only
  while (right.size() < 40) {
    const PoseSample sample = cell.sample(test::BentCell::random_motors(random), true, random);
    if (sample.lamps_B[0].x() > 0.05) right.push_back(sample);
  }
  const std::vector<PoseSample> candidates = cell.samples(120, 0, random);
  const NextPlaces next = choose_next_places(estimate_of(cell, right), candidates, 12);
  REQUIRE(next.chosen.size() == 12);
  REQUIRE(next.sigmas.size() == 13);
  for (std::size_t i = 0; i < 4; ++i) CHECK(candidates[next.chosen[i]].lamps_B[0].x() < 0.05);
  CHECK(std::is_sorted(next.sigmas.rbegin(), next.sigmas.rend()));
  std::vector<PoseSample> all = right;
  for (const std::size_t i : next.chosen) all.push_back(candidates[i]);
  const double promised = next.sigmas.back();
  const double after = choose_next_places(estimate_of(cell, all), candidates, 0).sigmas.front();
  CHECK(after == Approx(promised).epsilon(0.15));
  CHECK(after < 0.5 * next.sigmas.front());
}

TEST_CASE("What is read in any case counts before the first choice") {
  const test::BentCell cell;
  std::mt19937 random(63);
  const auto samples = cell.samples(20, 0, random), candidates = cell.samples(60, 0, random);
  const JointEstimate estimate = estimate_of(cell, samples);
  const auto sigma_with = [&](const std::vector<PoseSample>& first) {
    return choose_next_places(estimate, candidates, 0, first).sigmas.front();
  };
  CHECK(sigma_with(cell.samples(20, 0, random)) < 0.8 * sigma_with({}));
}

TEST_CASE("No more places are proposed than there are candidates") {
  const test::BentCell cell;
  std::mt19937 random(62);
  const auto samples = cell.samples(20, 0, random);
  CHECK(choose_next_places(estimate_of(cell, samples), cell.samples(3, 0, random), 10)
            .chosen.size() == 3);
}

}  // namespace
}  // namespace planar
