#include "planar_servo/learn/error_map/fit/rbf_fit.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/learn/error_map/fit/rbf_fit.h"
#include "support/error_fields.h"

namespace planar {
namespace {

// The tuning stops within 3 % of width and ridge; the error is flat there.
constexpr double kFlat = 1e-3;

double loo_rms(const MapSites& sites, const TailBasis& tail, const RadialKernel& kernel,
               double ridge) {
  return sites.sample_rms(fit_rbf(sites, tail, kernel, ridge).left_out.residuals);
}

TEST_CASE("The tuned width and ridge are a minimum of the leave-one-out error") {
  const auto positions = GENERATE(test::ring_positions(120), test::random_positions(120, 6));
  const MapSites sites =
      merge_samples(test::measure(test::bumpy_field, positions, test::kFieldNoise, 1));
  const TailBasis tail = tail_for(sites.positions);
  const auto shape = GENERATE(KernelShape::kGaussian, KernelShape::kMultiquadric);
  const TunedKernel tuned = tune_rbf(sites, tail, shape);
  const double width = tuned.kernel.width;
  CHECK(tuned.kernel.shape == shape);
  CHECK(std::sqrt(tuned.squared_misses.mean()) == Approx(tuned.loo_rms));
  CHECK(tuned.loo_rms == Approx(loo_rms(sites, tail, tuned.kernel, tuned.ridge)));
  for (const double factor : {0.5, 0.8, 1.25, 2.0}) {
    CHECK(loo_rms(sites, tail, {shape, factor * width, tuned.kernel.span}, tuned.ridge) >
          (1 - kFlat) * tuned.loo_rms);
    CHECK(loo_rms(sites, tail, tuned.kernel, factor * tuned.ridge) > (1 - kFlat) * tuned.loo_rms);
  }
}

TEST_CASE("Tuning survives data without any error and data of a plane") {
  const auto slope = GENERATE(0.0, 1e-3);
  const auto plane = [slope](const Eigen::Vector2d& p) { return Eigen::Vector2d(slope * p); };
  const MapSites sites = merge_samples(test::measure(plane, test::ring_positions(50), 0.0, 1));
  const TunedKernel tuned = tune_rbf(sites, tail_for(sites.positions), KernelShape::kGaussian);
  CHECK(tuned.loo_rms < 1e-12);
  CHECK(tuned.kernel.width > 0.0);
  CHECK(tuned.ridge > 0.0);
}

MapSites sparse_sites(const test::ErrorField& field, double stated_sigma) {
  auto samples = test::measure(field, test::ring_positions(100), test::kFieldNoise, 3);
  for (ErrorSample& sample : samples) sample.sigma = stated_sigma;
  return merge_samples(samples);
}

double noise_of_fit(const MapSites& sites) {
  const TailBasis tail = tail_for(sites.positions, 2);
  const TunedKernel tuned = tune_rbf(sites, tail, KernelShape::kMultiquadric);
  return fit_rbf(sites, tail, tuned.kernel, tuned.ridge).map.noise_sigma();
}

// The penalty's kink is reached as closely as the search goes.
constexpr double kNearlyAll = 0.95;

TEST_CASE("Noise that the instruments state is found, however far apart the samples lie") {
  CHECK(noise_of_fit(sparse_sites(test::bumpy_field, 0.0)) < 0.5 * test::kFieldNoise);
  CHECK(noise_of_fit(sparse_sites(test::bumpy_field, test::kFieldNoise)) >
        kNearlyAll * test::kFieldNoise);
}

TEST_CASE("Stating far too much noise does not smooth a field away that the samples resolve") {
  CHECK(noise_of_fit(sparse_sites(test::lens_field, 10.0 * test::kFieldNoise)) <
        1.5 * test::kFieldNoise);
}

}  // namespace
}  // namespace planar
