#include "planar_servo/core/numerics/statistics.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

namespace planar {
namespace {

TEST_CASE("A summary holds the textbook figures") {
  const Summary s = summarize({3.0, 4.0, 0.0, 5.0});
  CHECK(s.n == 4);
  CHECK(s.mean == Approx(3.0));
  CHECK(s.rms == Approx(std::sqrt(50.0 / 4.0)));
  CHECK(s.max == 5.0);
  CHECK(s.p95 == Approx(4.85));  // between the third and fourth of 0, 3, 4, 5
}

TEST_CASE("The robust sigma does not move when one value is absurd") {
  const double clean = robust_sigma({1.0, 2.0, 3.0, 4.0, 5.0});
  CHECK(clean == Approx(1.4826));
  CHECK(robust_sigma({1.0, 2.0, 3.0, 4.0, 1e9}) == Approx(clean));
}

TEST_CASE("Correlation is 1 for a scaled copy and -1 for a mirrored one") {
  CHECK(correlation({1, 2, 4}, {3, 6, 12}) == Approx(1.0));
  CHECK(correlation({1, 2, 4}, {-1, -2, -4}) == Approx(-1.0));
  CHECK(std::isnan(correlation({1, 2, 4}, {5, 5, 5})));
}

TEST_CASE("Statistics of an empty set are refused") {
  CHECK_THROWS_AS(mean({}), std::invalid_argument);
  CHECK_THROWS_AS(summarize({}), std::invalid_argument);
  CHECK_THROWS_AS(correlation({1.0}, {1.0, 2.0}), std::invalid_argument);
}

}  // namespace
}  // namespace planar
