#include "planar_servo/calibration/readings/change_point.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr int kPlaces = 100;

enum class Visit { kAtRandom, kSpiral, kRings };
enum class Pointing { kOneWay, kAnyWay };

Eigen::Vector2d place_of(Visit visit, int i, std::mt19937& random) {
  std::uniform_real_distribution<double> anywhere(-0.45, 0.45);
  if (visit == Visit::kAtRandom) return {anywhere(random), anywhere(random)};
  if (visit == Visit::kSpiral)
    return 0.5 * std::sqrt((i + 5.0) / kPlaces) * rotation2d(2.4 * i).col(0);
  const int ring = i / 10;
  return (0.05 + 0.045 * ring) * rotation2d(2.0 * kPi / 10.0 * i).col(0);
}

/// A vision error of three waves and a bend, 0.15 mm, with noise of 0.015 mm.
std::vector<TimedError> healthy_errors(unsigned seed, Visit visit,
                                       Pointing pointing = Pointing::kOneWay) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> phase(0.0, 2.0 * kPi);
  std::normal_distribution<double> noise(0.0, 0.015 * kMillimetre);
  const double a = phase(random), b = phase(random), c = phase(random);
  std::vector<TimedError> errors;
  for (int i = 0; i < kPlaces; ++i) {
    const Eigen::Vector2d p = place_of(visit, i, random);
    const Eigen::Vector2d field(std::sin(9.0 * p.x() + 4.0 * p.y() + a) + 4.0 * p.squaredNorm(),
                                std::sin(8.0 * p.y() + b) + 0.5 * std::sin(14.0 * p.x() + c));
    errors.push_back({p, 0.15 * kMillimetre * field + Eigen::Vector2d{noise(random), noise(random)},
                      pointing == Pointing::kAnyWay ? phase(random) : 0.0});
  }
  return errors;
}

/// Adds outliers of 0.2 to 3 mm to a share of the errors.
void add_outliers(std::vector<TimedError>& errors, unsigned seed, double share) {
  std::mt19937 random(seed + 1000);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (TimedError& e : errors)
    if (uniform(random) < share)
      e.error += (0.2 + 2.8 * uniform(random)) * kMillimetre *
                 rotation2d(2.0 * kPi * uniform(random)).col(0);
}

void add_step(std::vector<TimedError>& errors, std::size_t first, const Eigen::Vector2d& step) {
  for (std::size_t i = first; i < errors.size(); ++i) errors[i].error += step;
}

/// Counts the steps that are seen in errors changed by `change`, which is given their seed.
template <typename Change>
int alarms(int seeds, Visit visit, const Change& change) {
  int found = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    std::vector<TimedError> errors = healthy_errors(static_cast<unsigned>(seed), visit);
    change(errors, static_cast<unsigned>(seed));
    found += find_change(errors) ? 1 : 0;
  }
  return found;
}

}  // namespace

TEST_CASE("A strong smooth field is no step, visited at random, on a spiral or ring after ring") {
  for (const Visit visit : {Visit::kAtRandom, Visit::kSpiral, Visit::kRings})
    CHECK(alarms(25, visit, [](auto&, unsigned) {}) == 0);
}

TEST_CASE("Neither a steady drift nor a warming that slows down is a step") {
  const auto steady = [](std::vector<TimedError>& errors, unsigned) {
    for (std::size_t i = 0; i < errors.size(); ++i)
      errors[i].error.x() += 0.1 * kMillimetre * static_cast<double>(i) / kPlaces;
  };
  const auto warming = [](std::vector<TimedError>& errors, unsigned) {
    for (std::size_t i = 0; i < errors.size(); ++i)
      errors[i].error.y() +=
          0.06 * kMillimetre * (1.0 - std::exp(-4.0 * static_cast<double>(i) / kPlaces));
  };
  for (const Visit visit : {Visit::kAtRandom, Visit::kSpiral}) {
    CHECK(alarms(10, visit, steady) == 0);
    CHECK(alarms(10, visit, warming) == 0);
  }
}

TEST_CASE("Outliers are not taken for a step, not even among the first places") {
  const auto strewn = [](std::vector<TimedError>& errors, unsigned seed) {
    add_outliers(errors, seed, 0.04);
    errors[seed % 6].error.x() += 3.0 * kMillimetre;
    errors[(seed + 2) % 6].error.y() += 0.3 * kMillimetre;
  };
  CHECK(alarms(12, Visit::kAtRandom, strewn) == 0);
  CHECK(alarms(12, Visit::kSpiral, strewn) == 0);
}

TEST_CASE("A reflector bumped is found at its place with its size, among outliers, too") {
  for (const double size_mm : {0.06, 0.1, 0.36})
    for (const std::size_t first : {7, 50, 93}) {
      const Eigen::Vector2d step = size_mm * kMillimetre * Eigen::Vector2d(0.6, -0.8);
      int found = 0;
      for (unsigned seed = 0; seed < 10; ++seed) {
        std::vector<TimedError> errors = healthy_errors(seed, Visit::kAtRandom);
        add_step(errors, first, step);
        add_outliers(errors, seed, 0.02);
        const auto change = find_change(errors);
        if (!change) continue;
        CHECK_FALSE(change->frame);
        const bool in_place =
            std::abs(static_cast<double>(change->first) - static_cast<double>(first)) <= 3.0;
        if (in_place && (change->step - step).norm() < 5.0 * change->sigma) ++found;
      }
      INFO(size_mm << " mm from place " << first);
      const bool is_hard = size_mm < 0.1 && first != 50;
      CHECK(found >= (is_hard ? 5 : 9));
    }
}

TEST_CASE("Errors that do not drift have no trend, whatever the order of the places") {
  for (const Visit visit : {Visit::kAtRandom, Visit::kSpiral, Visit::kRings})
    for (unsigned seed = 0; seed < 10; ++seed) CHECK_FALSE(find_trend(healthy_errors(seed, visit)));
}

TEST_CASE("A trend is found with its size, and with the frame in which it is constant") {
  const Eigen::Vector2d size(0.03 * kMillimetre, -0.04 * kMillimetre);
  for (unsigned seed = 0; seed < 10; ++seed) {
    std::vector<TimedError> steady = healthy_errors(seed, Visit::kAtRandom);
    std::vector<TimedError> turning = healthy_errors(seed, Visit::kAtRandom, Pointing::kAnyWay);
    for (std::size_t i = 0; i < steady.size(); ++i) {
      const Eigen::Vector2d now = size * static_cast<double>(i) / (kPlaces - 1.0);
      steady[i].error += now;
      turning[i].error += rotation2d(turning[i].phi) * now;
    }
    const auto trend = find_trend(steady), of_tool = find_trend(turning);
    REQUIRE(trend);
    REQUIRE(of_tool);
    CHECK((trend->size - size).norm() < 5.0 * trend->sigma);
    CHECK_FALSE(trend->frame);
    CHECK((of_tool->size - size).norm() < 5.0 * of_tool->sigma);
    CHECK(of_tool->frame == StepFrame::kTool);
  }
}

TEST_CASE("Where the tool is turned, a step says whether it turns with the tool") {
  const Eigen::Vector2d step(0.1 * kMillimetre, 0.0);
  std::vector<TimedError> bumped = healthy_errors(1, Visit::kAtRandom, Pointing::kAnyWay);
  std::vector<TimedError> shifted = bumped;
  for (std::size_t i = 40; i < bumped.size(); ++i)
    bumped[i].error += rotation2d(bumped[i].phi) * step;
  add_step(shifted, 40, step);
  const auto with_tool = find_change(bumped), with_base = find_change(shifted);
  REQUIRE(with_tool);
  REQUIRE(with_base);
  CHECK(with_tool->frame == StepFrame::kTool);
  CHECK(with_base->frame == StepFrame::kBase);
  CHECK((with_tool->step - step).norm() < 5.0 * with_tool->sigma);
}

TEST_CASE("A step costs its size times the share of the places that do not show the last state") {
  ChangePoint change;
  change.step = {0.0, 0.1 * kMillimetre};
  change.first = 20;
  CHECK(change.cost(100) == Approx(0.08 * kMillimetre));
  change.first = 80;
  CHECK(change.cost(100) == Approx(0.08 * kMillimetre));
}

TEST_CASE("What is left beside a step shows the step and nothing of the field") {
  std::vector<TimedError> errors = healthy_errors(3, Visit::kAtRandom);
  add_step(errors, 60, {0.3 * kMillimetre, 0.0});
  const auto change = find_change(errors);
  REQUIRE(change);
  REQUIRE(change->left.size() == errors.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double expected = i < change->first ? 0.0 : change->step.x();
    CHECK(std::abs(change->left[i].x() - expected) < 0.08 * kMillimetre);
  }
}

TEST_CASE("Errors of exactly nothing have no step") {
  std::vector<TimedError> nothing;
  for (int i = 0; i < 40; ++i) nothing.push_back({{0.01 * (i % 8), 0.01 * (i / 8)}, {0.0, 0.0}});
  CHECK_FALSE(find_change(nothing));
}

TEST_CASE("One outlier is no step, and few places say nothing") {
  std::vector<TimedError> errors = healthy_errors(1, Visit::kAtRandom);
  errors.back().error.x() += 0.3 * kMillimetre;
  CHECK_FALSE(find_change(errors));
  errors.resize(20);
  add_step(errors, 10, {5.0 * kMillimetre, 0.0});
  CHECK_FALSE(find_change(errors));
}

}  // namespace planar
