#include "planar_servo/certificate/cell_accuracy.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/statistics.h"

namespace planar {
namespace {

constexpr int kSets = 400;

/// An anisotropic cloud about (4, 0), three times as wide as high.
PoseErrors drawn_errors(std::mt19937& random, std::size_t n) {
  std::normal_distribution<double> wide(4.0, 3.0), high(0.0, 1.0);
  PoseErrors errors;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = wide(random), y = high(random);
    errors.emplace_back(x, y);
  }
  return errors;
}

bool holds(const Interval& interval, double value) {
  return interval.first < value && value < interval.second;
}

TEST_CASE("The intervals of AP and RP hold them as often as they say") {
  std::mt19937 random(5);
  const double true_rp = pose_accuracy(drawn_errors(random, 200000)).repeatability;
  int ap = 0, rp = 0;
  for (int i = 0; i < kSets; ++i) {
    const PoseIntervals intervals = pose_intervals(drawn_errors(random, 30)).value();
    if (holds(intervals.accuracy, 4.0)) ++ap;
    if (holds(intervals.repeatability, true_rp)) ++rp;
  }
  CHECK(ap / double(kSets) == Approx(0.95).margin(0.033));  // three sigmas
  CHECK(rp / double(kSets) == Approx(0.95).margin(0.033));
}

TEST_CASE("The interval of an AP that is no longer than its own uncertainty holds it, too") {
  constexpr std::size_t kErrors = 30;
  const double true_ap = 1.5 / std::sqrt(static_cast<double>(kErrors));
  std::mt19937 random(10);
  std::normal_distribution<double> normal;
  int held = 0;
  for (int i = 0; i < kSets; ++i) {
    PoseErrors errors;
    for (std::size_t k = 0; k < kErrors; ++k) {
      const double x = normal(random), y = normal(random);
      errors.emplace_back(true_ap + x, y);
    }
    const PoseIntervals intervals = pose_intervals(errors).value();
    if (holds(intervals.accuracy, true_ap)) ++held;
    CHECK(intervals.accuracy.second > pose_accuracy(errors).accuracy);
  }
  CHECK(held / double(kSets) > 0.917);  // three sigmas below 0.95
}

TEST_CASE("The intervals of a mean and an rms hold them about as often as they say") {
  std::mt19937 random(6);
  std::weibull_distribution<double> rayleigh(2.0, 1.0);
  int held_mean = 0, held_rms = 0;
  for (int i = 0; i < kSets; ++i) {
    std::vector<double> lengths(60);
    for (double& length : lengths) length = rayleigh(random);
    if (holds(figure_interval(lengths, mean).value(), std::sqrt(M_PI) / 2.0)) ++held_mean;
    if (holds(figure_interval(lengths, rms).value(), 1.0)) ++held_rms;
  }
  CHECK(held_mean / double(kSets) == Approx(0.94).margin(0.04));
  CHECK(held_rms / double(kSets) == Approx(0.94).margin(0.04));
}

TEST_CASE("Chance lets halves of the same values differ in one of twenty") {
  std::mt19937 random(7);
  std::normal_distribution<double> noise;
  int alarms = 0;
  for (int i = 0; i < kSets; ++i) {
    std::vector<double> values(20);
    for (double& value : values) value = noise(random);
    const auto difference = [&](const std::vector<std::size_t>& order) {
      double sum = 0.0;
      for (std::size_t k = 0; k < order.size(); ++k)
        sum += k < order.size() / 2 ? values[order[k]] : -values[order[k]];
      return std::abs(sum);
    };
    std::vector<std::size_t> as_drawn(values.size());
    for (std::size_t k = 0; k < as_drawn.size(); ++k) as_drawn[k] = k;
    if (difference(as_drawn) > chance_level(values.size(), difference)) ++alarms;
  }
  CHECK(alarms / double(kSets) == Approx(0.05).margin(0.033));
}

TEST_CASE("Five values give no interval") {
  std::mt19937 random(8);
  CHECK_FALSE(pose_intervals(drawn_errors(random, 5)));
  CHECK(pose_intervals(drawn_errors(random, 6)));
  CHECK_FALSE(figure_interval({1.0, 2.0, 3.0, 4.0, 5.0}, mean));
}

TEST_CASE("Errors that do not scatter have the interval of a point") {
  const PoseIntervals intervals = pose_intervals(PoseErrors(8, {3.0, 4.0})).value();
  CHECK(intervals.accuracy.first == Approx(5.0));
  CHECK(intervals.accuracy.second == Approx(5.0));
  CHECK(intervals.repeatability.second == Approx(0.0).margin(1e-12));
}

}  // namespace
}  // namespace planar
