#include "planar_servo/learn/error_map/fit/pair_checks.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/learn/error_map/fit_error_map.h"
#include "support/error_fields.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

std::vector<ErrorSample> good() {
  return test::measure(test::lens_field, test::random_positions(50, 1), test::kFieldNoise, 1);
}

/// With vision's positions times `vision` and the tracker's times `tracker`.
std::vector<ErrorSample> scaled(double vision, double tracker) {
  std::vector<ErrorSample> samples = good();
  for (ErrorSample& sample : samples) {
    const Eigen::Vector2d p_tracker = tracker * (sample.p_vision - sample.error);
    sample.p_vision *= vision;
    sample.error = sample.p_vision - p_tracker;
  }
  return samples;
}

void require_one_unit_of(const std::vector<ErrorSample>& samples) {
  const MapSites sites = merge_samples(samples);
  require_one_unit(sites.positions, sites.positions - sites.errors);
}

TEST_CASE("Pairs of a working cell are plausible, with a few wild rows, too") {
  CHECK_NOTHROW(require_one_unit_of(good()));
  auto samples = good();
  for (std::size_t i = 0; i < 10; ++i) samples[i].error.x() += 0.5;
  CHECK_NOTHROW(require_one_unit_of(samples));
}

TEST_CASE("Metres in one of the columns are named with the remedy") {
  const auto samples = GENERATE(scaled(1e-3, 1.0), scaled(1.0, 1e-3));
  CHECK_THROWS_AS(require_one_unit_of(samples), InputError);
  CHECK_THROWS_MATCHES(require_one_unit_of(samples), InputError,
                       Refused(Cause::kContradiction, "like metres"));
}

TEST_CASE("Positions of another scale are refused, metres or not") {
  CHECK_THROWS_MATCHES(require_one_unit_of(scaled(25.4, 1.0)), InputError,
                       Refused(Cause::kContradiction, "frame and unit"));
  CHECK_THROWS_MATCHES(require_one_unit_of(scaled(1.0, 25.4)), InputError,
                       Refused(Cause::kContradiction, "frame and unit"));
}

TEST_CASE("Swapped axes and another datum are no vision error") {
  auto swapped = good();
  for (ErrorSample& sample : swapped)
    sample.error = sample.p_vision - (sample.p_vision - sample.error).reverse();
  CHECK_THROWS_MATCHES(require_one_unit_of(swapped), InputError,
                       Refused(Cause::kContradiction, "x and y"));
  auto shifted = good();
  for (ErrorSample& sample : shifted) sample.error += Eigen::Vector2d(0.5, 0.0);
  CHECK_THROWS_MATCHES(require_one_unit_of(shifted), InputError,
                       Refused(Cause::kContradiction, "frame and unit"));
}

TEST_CASE("What all pairs share is named instead of learned") {
  const auto moved = [](const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& tracker) {
    auto samples = good();
    for (ErrorSample& sample : samples)
      sample.error = sample.p_vision - tracker(sample.p_vision - sample.error);
    return samples;
  };
  const auto shifted = moved(
      [](const Eigen::Vector2d& p) { return Eigen::Vector2d(p + Eigen::Vector2d(0.015, 0.0)); });
  CHECK_THROWS_MATCHES(require_one_unit_of(shifted), InputError,
                       Refused(Cause::kContradiction, "shifted by (-14."));
  const auto turned =
      moved([](const Eigen::Vector2d& p) { return Eigen::Vector2d(rotation2d(-0.05) * p); });
  CHECK_THROWS_MATCHES(require_one_unit_of(turned), InputError,
                       Refused(Cause::kContradiction, "turned by 2.8"));
  const auto grown = moved([](const Eigen::Vector2d& p) { return Eigen::Vector2d(p / 1.04); });
  CHECK_THROWS_MATCHES(require_one_unit_of(grown), InputError,
                       Refused(Cause::kContradiction, "1.04"));
  auto slightly = good();
  for (ErrorSample& sample : slightly)
    sample.error = 0.1 * sample.error + Eigen::Vector2d(-2.4e-3, 0.0);
  CHECK_NOTHROW(require_one_unit_of(slightly));
  CHECK_THAT(doubt_of_shared_error(slightly).value().fault, Contains("vision is shifted by (-2."));
  CHECK_FALSE(doubt_of_shared_error(good()));
}

TEST_CASE("A small mirrored field is named") {
  std::vector<ErrorSample> samples;
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector2d p(0.01 * i, 5e-3 * std::sin(i));
    samples.push_back({std::to_string(i), p, {0.0, 2.0 * p.y()}});
  }
  CHECK_THROWS_MATCHES(require_one_unit_of(samples), InputError,
                       Refused(Cause::kContradiction, "mirror"));
}

TEST_CASE("Micrometres on both sides are named") {
  CHECK_THROWS_MATCHES(require_one_unit_of(scaled(1e3, 1e3)), InputError,
                       Refused(Cause::kInvalid, "micrometres"));
}

TEST_CASE("A frozen tracker is refused, and one reading for several frames is not") {
  auto samples = good();
  const Eigen::Vector2d frozen = samples[10].p_vision - samples[10].error;
  for (std::size_t i = 10; i < 14; ++i) samples[i].error = samples[i].p_vision - frozen;
  CHECK_THROWS_MATCHES(fit_error_map({samples, MapMethod::kAuto, 0.0}), InputError,
                       Refused(Cause::kContradiction, "4 pairs"));
  CHECK_THROWS_MATCHES(fit_error_map({samples, MapMethod::kAuto, 0.0}), InputError,
                       Refused(Cause::kContradiction, "'10' and '11'"));
  samples = good();
  samples.push_back(samples[3]);
  samples.back().p_vision.x() += 0.01e-3;
  samples.back().error.x() += 0.01e-3;
  CHECK_NOTHROW(require_live_tracker(samples));
}

TEST_CASE("Metres in all columns are named") {
  CHECK_THROWS_MATCHES(require_one_unit_of(scaled(1e-3, 1e-3)), InputError,
                       Refused(Cause::kInvalid, "like metres"));
}

TEST_CASE("A fit refuses metres among millimetres, by every method") {
  const MapMethod method = GENERATE(MapMethod::kAuto, MapMethod::kIdw, MapMethod::kHandWidth);
  CHECK_THROWS_MATCHES(fit_error_map({scaled(1e-3, 1.0), method, 0.048}), InputError,
                       Refused(Cause::kContradiction, "like metres"));
}

TEST_CASE("A tracker that rested at one place most of the time is no mix of units") {
  auto samples = good();
  const Eigen::Vector2d rest = samples.front().p_vision;
  for (int i = 0; i < 100; ++i)
    samples.push_back({"rest", rest + Eigen::Vector2d(1e-6 * i, 0.0), {0.0, 3e-6 * (i % 7)}});
  CHECK_NOTHROW(require_one_unit_of(samples));
}

}  // namespace
}  // namespace planar
