#include "planar_servo/learn/error_map/fit/rbf_fit.h"

#include <catch2/catch.hpp>

#include "support/error_fields.h"

namespace planar {
namespace {

const RbfFamily kGaussian{KernelShape::kGaussian, 1};
const RbfFamily kMultiquadric{KernelShape::kMultiquadric, 2};

TunedFamily best_for(const test::ErrorField& field, const RbfFamily& first,
                     const RbfFamily& other) {
  const MapSites sites =
      merge_samples(test::measure(field, test::ring_positions(200), test::kFieldNoise, 1));
  return best_of(tune(sites, {first, other}));
}

TEST_CASE("A field with a knee takes the kernel of many scales, with its tail") {
  const TunedFamily best = best_for(test::glow_field, kGaussian, kMultiquadric);
  CHECK(best.tuned.kernel.shape == KernelShape::kMultiquadric);
  CHECK(best.tail_basis.degree == 2);
}

TEST_CASE("Where another family does no better the first one stands") {
  const auto nothing = [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); };
  CHECK(best_for(nothing, kGaussian, kMultiquadric).tuned.kernel.shape == KernelShape::kGaussian);
  CHECK(best_for(test::glow_field, kMultiquadric, kGaussian).tuned.kernel.shape ==
        KernelShape::kMultiquadric);
}

TEST_CASE("Tuning anew from what nearly the same sites were tuned to finds the same minimum") {
  const MapSites sites = merge_samples(
      test::measure(test::glow_field, test::ring_positions(120), test::kFieldNoise, 1));
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 1; i < sites.size(); ++i) kept.push_back(i);
  const MapSites fewer = sites.subset(kept);
  const TunedFamily anew = tune(fewer, kMultiquadric);
  const TunedFamily again = retune(fewer, tune(sites, kMultiquadric));
  constexpr double kFlat = 0.01;  // two searches may stop in two dips of a noisy, flat valley
  CHECK(again.tuned.loo_rms == Approx(anew.tuned.loo_rms).epsilon(kFlat));
}

}  // namespace
}  // namespace planar
