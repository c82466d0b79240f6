#include "planar_servo/calibration/readings/change_point.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr int kPlaces = 150;

enum class Visit { kAtRandom, kRowByRow };

/// A vision error of three waves that no cubic follows, 0.05 mm, with noise of 0.015 mm.
std::vector<TimedError> healthy_errors(unsigned seed, Visit visit, double trend = 0.0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-0.45, 0.45), phase(0.0, 6.28);
  std::normal_distribution<double> noise(0.0, 0.015 * kMillimetre);
  const double a = phase(random), b = phase(random), c = phase(random);
  std::vector<TimedError> errors;
  for (int i = 0; i < kPlaces; ++i) {
    const Eigen::Vector2d p = visit == Visit::kAtRandom
                                  ? Eigen::Vector2d(place(random), place(random))
                                  : Eigen::Vector2d(0.06 * (i % 15) - 0.42, 0.09 * (i / 15) - 0.4);
    const Eigen::Vector2d field(std::sin(9.0 * p.x() + 4.0 * p.y() + a),
                                std::sin(8.0 * p.y() + b) + 0.5 * std::sin(14.0 * p.x() + c));
    errors.push_back({p, 0.05 * kMillimetre * field + trend * i * Eigen::Vector2d::Ones() +
                             Eigen::Vector2d(noise(random), noise(random))});
  }
  return errors;
}

int alarms(int seeds, Visit visit, double trend) {
  int found = 0;
  for (int seed = 0; seed < seeds; ++seed)
    found += find_change(healthy_errors(static_cast<unsigned>(seed), visit, trend)) ? 1 : 0;
  return found;
}

}  // namespace

TEST_CASE("Errors without a step show none, visited at random, row by row, or with a slow drift") {
  constexpr int kSeeds = 2000;
  constexpr int kMost = 8;  // 2 expected
  CHECK(alarms(kSeeds, Visit::kAtRandom, 0.0) <= kMost);
  CHECK(alarms(kSeeds, Visit::kRowByRow, 0.0) <= kMost);
  CHECK(alarms(kSeeds, Visit::kAtRandom, 0.001 * kMillimetre) <= kMost);
}

TEST_CASE("Outliers are not taken for a step, not even among the first places") {
  int found = 0;
  for (unsigned seed = 0; seed < 500; ++seed) {
    std::vector<TimedError> errors = healthy_errors(seed, Visit::kAtRandom);
    std::mt19937 random(seed + 1);
    std::uniform_int_distribution<int> anywhere(0, kPlaces - 1), early(0, 5);
    errors[static_cast<std::size_t>(early(random))].error.x() += 3.0 * kMillimetre;
    for (int i = 0; i < 3; ++i)
      errors[static_cast<std::size_t>(anywhere(random))].error.y() -= 2.0 * kMillimetre;
    found += find_change(errors) ? 1 : 0;
  }
  CHECK(found <= 4);
}

TEST_CASE("A reflector bumped midway is found at its place with its size") {
  const Eigen::Vector2d step(0.06 * kMillimetre, -0.08 * kMillimetre);
  for (const Visit visit : {Visit::kAtRandom, Visit::kRowByRow}) {
    int found = 0;
    for (unsigned seed = 0; seed < 100; ++seed) {
      std::vector<TimedError> errors = healthy_errors(seed, visit);
      for (std::size_t i = 70; i < errors.size(); ++i) errors[i].error += step;
      const auto change = find_change(errors);
      if (!change) continue;
      const bool in_place = std::abs(static_cast<double>(change->first) - 70.0) <= 6.0;
      if (in_place && (change->step - step).norm() < 6.0 * change->sigma) ++found;
    }
    INFO((visit == Visit::kAtRandom ? "at random" : "row by row"));
    CHECK(found >= (visit == Visit::kAtRandom ? 95 : 50));
  }
}

TEST_CASE("One outlier of the size that a fit leaves in is no step, and few places say nothing") {
  std::vector<TimedError> errors = healthy_errors(1, Visit::kAtRandom);
  errors.back().error.x() += 0.3 * kMillimetre;
  CHECK_FALSE(find_change(errors));
  errors.resize(20);
  for (std::size_t i = 10; i < 20; ++i) errors[i].error.x() += 5.0 * kMillimetre;
  CHECK_FALSE(find_change(errors));
}

}  // namespace planar
