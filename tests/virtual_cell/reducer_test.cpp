#include "planar_servo/virtual_cell/virtual_drive.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "planar_servo/base/core/units.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {
namespace {

constexpr double kGear = 100.0;
constexpr int kSamples = 400;  // per motor turn

/// Returns what comes out over one motor turn from `begin_rad` on, less what should.
std::vector<double> errors_over_a_turn(const ReducerTruth& truth, double begin_rad) {
  Reducer reducer(truth, begin_rad, kGear);
  std::vector<double> errors;
  for (int i = 0; i < kSamples; ++i) {
    const double motor_rad = begin_rad + 2.0 * kPi / kGear * i / kSamples;
    reducer.follow(motor_rad);
    errors.push_back(reducer.output_rad() - motor_rad);
  }
  return errors;
}

/// Returns the amplitude of a sine that passes `order` times.
double amplitude_of(const std::vector<double>& errors, int order) {
  double cosine = 0.0, sine = 0.0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double angle = 2.0 * kPi * order * static_cast<double>(i) / kSamples;
    cosine += errors[i] * std::cos(angle);
    sine += errors[i] * std::sin(angle);
  }
  return 2.0 / kSamples * std::hypot(cosine, sine);
}

ReducerTruth rippling() {
  ReducerTruth truth;
  truth.ripple = {{0.008 * kDegree, 0.4, 1}, {0.001 * kDegree, 0.9, 20}};
  truth.ripple_modulation = 0.1;
  truth.ripple_skew = 0.2;
  return truth;
}

}  // namespace

TEST_CASE(
    "A gear's ripple has the motor's turn, its stated size behind the gear, and more orders") {
  const std::vector<double> errors = errors_over_a_turn(rippling(), 0.3);
  CHECK(amplitude_of(errors, 1) == Approx(0.008 * kDegree).epsilon(0.15));
  CHECK(amplitude_of(errors, 20) == Approx(0.001 * kDegree).epsilon(0.15));
  // The skew makes half its own size of the next order.
  CHECK(amplitude_of(errors, 2) == Approx(0.1 * 0.008 * kDegree).epsilon(0.2));
  CHECK(amplitude_of(errors, 7) < 0.01 * 0.008 * kDegree);
}

TEST_CASE("A gear's ripple swells and fades by the stated share as the output turns") {
  double least = 1.0, greatest = 0.0;
  for (int place = 0; place < 60; ++place) {
    const double size = amplitude_of(errors_over_a_turn(rippling(), 0.1 * place), 1);
    least = std::min(least, size);
    greatest = std::max(greatest, size);
  }
  CHECK(greatest / least == Approx(1.1 / 0.9).epsilon(0.03));
}

TEST_CASE("Uneven microsteps repeat 50 and 200 times per motor turn, in shares of a full step") {
  ReducerTruth truth;
  truth.microsteps = {{0.03 * kFullStep, 0.1, 50}, {0.01 * kFullStep, 0.2, 200}};
  Reducer reducer(truth, 0.0, kGear);
  double greatest = 0.0, last_rad = reducer.output_rad();
  for (int i = 1; i < 10000; ++i) {
    const double motor_rad = 2.0 * kPi / kGear * i / 10000;
    reducer.follow(motor_rad);
    greatest = std::max(greatest, std::abs(reducer.output_rad() - motor_rad));
    REQUIRE(reducer.output_rad() > last_rad);
    last_rad = reducer.output_rad();
  }
  CHECK(greatest * kGear > 0.03 * kFullStep);
  CHECK(greatest * kGear < 0.04 * kFullStep);
}

TEST_CASE("A gear stays wound up after a turn back, and one approach leaves a fifth of that") {
  ReducerTruth truth;
  truth.hysteresis_rad = 0.002 * kDegree;
  truth.forgetting_rad = 0.13 * kDegree;
  const auto wound = [&](double from_rad) {
    Reducer reducer(truth, from_rad, kGear);
    reducer.follow(-0.2 * kDegree);
    reducer.follow(0.0);
    return reducer.output_rad();
  };
  const double from_below = wound(-1.0), from_above = wound(1.0);
  CHECK(from_below == Approx(truth.hysteresis_rad).epsilon(1e-6));
  const double left = (from_below - from_above) / (2.0 * truth.hysteresis_rad);
  CHECK(left == Approx(std::exp(-0.2 / 0.13)).epsilon(1e-3));
  CHECK(left > 0.15);
  CHECK(left < 0.30);
}

TEST_CASE("Play that varies over the turn is wide here and narrow there, 0.05 deg on the mean") {
  ReducerTruth truth;
  truth.backlash_rad = 0.05 * kDegree;
  truth.backlash_variation = 0.4;
  double widest = 0.0, narrowest = 1.0;
  for (double at_rad = 0.0; at_rad < 2.5; at_rad += 0.05) {
    Reducer up(truth, at_rad - 0.1), down(truth, at_rad + 0.1);
    up.follow(at_rad);
    down.follow(at_rad);
    const double play = down.output_rad() - up.output_rad();
    widest = std::max(widest, play);
    narrowest = std::min(narrowest, play);
  }
  CHECK(widest == Approx(1.4 * truth.backlash_rad).epsilon(0.02));
  CHECK(narrowest == Approx(0.6 * truth.backlash_rad).epsilon(0.02));
}

TEST_CASE("A gear tells to which side its motor turned last") {
  Reducer reducer({}, 0.0, kGear);
  reducer.follow(0.1);
  CHECK_FALSE(reducer.turned_negative());
  reducer.follow(0.05);
  CHECK(reducer.turned_negative());
  reducer.follow(0.05);
  CHECK(reducer.turned_negative());
}

}  // namespace planar
