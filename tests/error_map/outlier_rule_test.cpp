#include "planar_servo/learn/error_map/fit/outliers.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace planar {
namespace {

TEST_CASE("The length that a share of Student's t vectors exceeds is exceeded by that share") {
  const double dof = GENERATE(2.0, 5.0, 30.0);
  constexpr int kDraws = 200000;
  constexpr double kSampling = 0.005;  // five standard deviations of a share, at most
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::chi_squared_distribution<double> chi_squared(dof);
  for (const double share : {0.5, 0.125, 0.01}) {
    int longer = 0;
    for (int i = 0; i < kDraws; ++i) {
      const double length = std::hypot(normal(random), normal(random));
      longer += length * std::sqrt(dof / chi_squared(random)) > residual_length(share, dof);
    }
    CHECK(longer / static_cast<double>(kDraws) == Approx(share).margin(kSampling));
  }
}

TEST_CASE("With ever more degrees of freedom Student's t is normal") {
  for (const double share : {0.5, 0.1, 1e-4})
    CHECK(residual_length(share, 1e6) == Approx(residual_length(share)).epsilon(1e-4));
}

TEST_CASE("Lengths tell the degrees of freedom of their tail") {
  const double dof = GENERATE(1.0, 3.0, 10.0, kNormal);
  constexpr int kCount = 4001;
  std::vector<double> lengths;
  lengths.reserve(kCount);
  for (int i = 0; i < kCount; ++i)
    lengths.push_back(0.02 * residual_length((i + 0.5) / kCount, dof));
  if (dof == kNormal)
    CHECK(tail_dof(lengths) > 1000.0);
  else
    CHECK(tail_dof(lengths) == Approx(dof).epsilon(0.01));
}

TEST_CASE("Lengths that fall off faster than normal ones count as normal") {
  CHECK(tail_dof({1.0, 1.0, 1.0, 1.1, 1.1, 1.1}) == kNormal);
}

}  // namespace
}  // namespace planar
