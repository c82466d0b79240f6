#include "planar_servo/learn/error_map/fit/map_sites.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/error.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<ErrorSample> triangle() {
  return {{"a", {0.0, 0.0}, {1e-3, 0.0}},
          {"b", {0.1, 0.0}, {2e-3, 0.0}},
          {"c", {0.0, 0.1}, {3e-3, 1e-3}}};
}

TEST_CASE("Samples at one position are averaged, and their scatter is kept") {
  auto samples = triangle();
  samples.push_back({"b again", {0.1, 0.0}, {4e-3, 0.0}});
  const MapSites sites = merge_samples(samples);
  REQUIRE(sites.size() == 3);
  CHECK(sites.errors(0, 1) == Approx(3e-3));
  CHECK(sites.counts[1] == 2.0);
  CHECK(sites.scatter[1] == Approx(2e-6));
  CHECK(sites.samples[1] == std::vector<std::size_t>{1, 3});
  const double mean_square = (1e-6 + 4e-6 + 16e-6 + 10e-6) / 4.0;
  CHECK(sites.sample_rms(sites.errors) == Approx(std::sqrt(mean_square)));
}

TEST_CASE("Every sample that is not finite is named") {
  auto samples = triangle();
  samples[0].p_vision.x() = kNan;
  samples[2].error.y() = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS(merge_samples(samples), InputError);
  CHECK_THROWS_MATCHES(merge_samples(samples), InputError, Refused(Cause::kInvalid, "pair a: "));
  CHECK_THROWS_MATCHES(merge_samples(samples), InputError, Refused(Cause::kInvalid, "pair c: "));
}

TEST_CASE("Fewer than three distinct positions are refused with their number") {
  auto samples = triangle();
  samples[2].p_vision = samples[1].p_vision;
  CHECK_THROWS_AS(merge_samples(samples), InputError);
  CHECK_THROWS_MATCHES(merge_samples(samples), InputError,
                       Refused(Cause::kInsufficient, "3 pairs have 2"));
  CHECK_THROWS_MATCHES(merge_samples({}), InputError, Refused(Cause::kInsufficient, "0 pairs"));
}

}  // namespace
}  // namespace planar
