#include "planar_servo/work/workpiece/bar_places.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kRadius = 0.5, kLength = 0.6;

TEST_CASE("Stances of a bar stay on the disc and turn evenly") {
  const auto stances = bar_stances(kRadius, kLength, 8);
  REQUIRE(stances.size() == 8);
  double farthest = 0.0;
  for (std::size_t i = 0; i < stances.size(); ++i) {
    CHECK(stances[i].turn == Approx(kPi * static_cast<double>(i) / 8.0));
    for (const double end : {-0.5, 0.5}) {
      const Eigen::Vector2d at =
          stances[i].middle_B + end * kLength * rotation2d(stances[i].turn).col(0);
      CHECK(at.norm() <= kRadius);
      farthest = std::max(farthest, at.norm());
    }
  }
  CHECK(farthest > 0.8 * kRadius);
  for (const BarStance& stance : bar_stances(0.2, kLength, 3)) CHECK(stance.middle_B.norm() == 0.0);
}

TEST_CASE("The next stance is the one unlike all that were taken, half a turn being none") {
  const auto wanted = bar_stances(kRadius, kLength, 8);
  std::vector<BarStance> taken;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const BarStance next = next_stance(wanted, taken, kLength);
    CHECK(std::none_of(taken.begin(), taken.end(), [&](const BarStance& other) {
      return (other.middle_B - next.middle_B).norm() < 1e-9 &&
             std::abs(std::remainder(other.turn - next.turn, kPi)) < 1e-9;
    }));
    taken.push_back({next.middle_B, next.turn + kPi});
  }
}

}  // namespace
}  // namespace planar
