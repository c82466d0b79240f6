#include "planar_servo/base/core/statistics.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

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

TEST_CASE("Quantiles lie between neighbours in size, in whatever order the values come") {
  CHECK(quantile({4.0, 1.0, 3.0, 2.0}, 0.5) == 2.5);
  CHECK(quantile({4.0, 1.0, 3.0, 2.0}, 0.25) == 1.75);
  CHECK(quantile({4.0, 1.0, 3.0, 2.0}, 0.0) == 1.0);
  CHECK(quantile({4.0, 1.0, 3.0, 2.0}, 1.0) == 4.0);
  CHECK(quantile({7.0}, 0.3) == 7.0);
}

std::vector<double> numbers_to(int n) {
  std::vector<double> values;
  for (int i = n; i > 0; --i) values.push_back(i);
  return values;
}

TEST_CASE("The interval of a median is that of the tables of order statistics") {
  using Interval = std::pair<double, double>;
  CHECK_FALSE(median_interval(numbers_to(5), 0.95));
  CHECK(median_interval(numbers_to(6), 0.95) == Interval(1.0, 6.0));
  CHECK(median_interval(numbers_to(10), 0.95) == Interval(2.0, 9.0));
  CHECK(median_interval(numbers_to(20), 0.95) == Interval(6.0, 15.0));
  CHECK(median_interval(numbers_to(100), 0.95) == Interval(40.0, 61.0));
  CHECK(median_interval(numbers_to(10000), 0.95) == Interval(4902.0, 5099.0));
}

TEST_CASE("The interval of a quantile is that of the binomial distribution") {
  using Interval = std::pair<double, double>;
  CHECK_FALSE(quantile_interval(numbers_to(71), 0.95, 0.95));  // 0.95^71 > 0.025
  CHECK(quantile_interval(numbers_to(72), 0.95, 0.95) == Interval(64.0, 72.0));
  CHECK(quantile_interval(numbers_to(100), 0.95, 0.95) == Interval(90.0, 100.0));
  CHECK(quantile_interval(numbers_to(200), 0.95, 0.95) == Interval(184.0, 197.0));
  CHECK(quantile_interval(numbers_to(100), 0.05, 0.95) == Interval(1.0, 11.0));
  CHECK_THROWS_AS(quantile_interval({1.0}, 1.0, 0.95), std::invalid_argument);
}

TEST_CASE("The interval of a median holds it as often as it says") {
  std::mt19937 random(3);
  std::exponential_distribution<double> skew(1.0);
  int held = 0;
  for (int i = 0; i < 4000; ++i) {
    std::vector<double> values(15);
    for (double& value : values) value = skew(random);
    const auto interval = median_interval(values, 0.95).value();
    if (interval.first < std::log(2.0) && std::log(2.0) < interval.second) ++held;
  }
  CHECK(held / 4000.0 == Approx(0.9648).margin(0.009));  // three sigmas
}

TEST_CASE("Statistics of an empty set are refused") {
  CHECK_THROWS_AS(mean({}), std::invalid_argument);
  CHECK_THROWS_AS(summarize({}), std::invalid_argument);
  CHECK_THROWS_AS(median_interval({}, 0.95), std::invalid_argument);
  CHECK_THROWS_AS(correlation({1.0}, {1.0, 2.0}), std::invalid_argument);
}

}  // namespace
}  // namespace planar
