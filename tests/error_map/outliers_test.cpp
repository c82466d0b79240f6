#include "planar_servo/learn/error_map/fit/outliers.h"

#include <catch2/catch.hpp>
#include <set>

#include "planar_servo/base/core/error.h"
#include "support/error_fields.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

const Eigen::Vector2d kAside(0.6, -0.8);

std::vector<ErrorSample> glow_samples(int count, std::uint32_t seed) {
  return test::measure(test::glow_field, test::random_positions(count, seed), test::kFieldNoise,
                       seed);
}

std::set<Eigen::Index> sites_of(const std::vector<Outlier>& outliers) {
  std::set<Eigen::Index> sites;
  for (const Outlier& outlier : outliers) sites.insert(outlier.site);
  return sites;
}

RobustFit fit_robustly(const std::vector<ErrorSample>& samples) {
  return fit_without_outliers(merge_samples(samples), {RbfFamily{KernelShape::kMultiquadric, 2}});
}

TEST_CASE("Clean samples are all kept") {
  const std::uint32_t seed = GENERATE(1U, 2U, 3U);
  const RobustFit robust = fit_robustly(glow_samples(200, seed));
  CHECK(robust.outliers.empty());
  CHECK(robust.kept.size() == 200);
}

TEST_CASE(
    "Two per cent of outliers are found, from half a millimetre to half a metre, and no others") {
  const double size = GENERATE(0.5e-3, 10e-3, 0.5);
  auto samples = glow_samples(200, 4);
  const std::set<Eigen::Index> bad{17, 60, 61, 155};
  for (const Eigen::Index i : bad) samples[static_cast<std::size_t>(i)].error += size * kAside;
  const RobustFit robust = fit_robustly(samples);
  CHECK(sites_of(robust.outliers) == bad);
  for (const Outlier& outlier : robust.outliers) {
    CHECK(outlier.residual == Approx(size).epsilon(0.2));
    CHECK(outlier.residual > outlier.limit);
  }
}

TEST_CASE("Rows paired with their neighbours' are found") {
  auto samples = glow_samples(200, 5);
  std::swap(samples[40].error, samples[90].error);
  samples[40].error += samples[90].p_vision - samples[40].p_vision;
  samples[90].error += samples[40].p_vision - samples[90].p_vision;
  const RobustFit robust = fit_robustly(samples);
  CHECK(sites_of(robust.outliers) == std::set<Eigen::Index>{40, 90});
}

TEST_CASE("Samples beside a step, which disagree among themselves, are kept") {
  const std::uint32_t seed = GENERATE(11U, 12U, 13U);
  const bool rings = GENERATE(true, false);
  const auto positions = rings ? test::ring_positions(200) : test::random_positions(200, seed);
  auto samples = test::measure(test::lens_field, positions, test::kFieldNoise, seed);
  for (ErrorSample& sample : samples)
    if (0.8 * sample.p_vision.x() + 0.6 * sample.p_vision.y() > 0.06) sample.error.x() += 0.4e-3;
  CHECK(fit_robustly(samples).outliers.empty());
}

TEST_CASE("Fifteen per cent of gross outliers are found") {
  const double size = GENERATE(10e-3, 0.3);
  auto samples = glow_samples(200, 7);
  std::set<Eigen::Index> bad;
  for (std::size_t i = 3; i < samples.size(); i += 7) {
    samples[i].error += size * kAside;
    bad.insert(static_cast<Eigen::Index>(i));
  }
  const RobustFit robust = fit_robustly(samples);
  CHECK(sites_of(robust.outliers) == bad);
}

TEST_CASE("More outliers than a fifth are refused with their number") {
  auto samples = glow_samples(100, 6);
  for (std::size_t i = 0; i < samples.size(); i += 3)
    samples[i].error += 5e-3 * static_cast<double>(i % 7 + 1) * kAside;
  CHECK_THROWS_AS(fit_robustly(samples), InputError);
  CHECK_THROWS_MATCHES(fit_robustly(samples), InputError,
                       Refused(Cause::kContradiction, "of 100 pairs"));
}

}  // namespace
}  // namespace planar
