#include "planar_servo/learn/error_map/fit/rbf_fit.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/error_fields.h"

namespace planar {
namespace {

// Condition of the kernel here is below 1e6.
constexpr double kShortcutRounding = 1e-8;

MapSites without(const MapSites& sites, Eigen::Index left_out) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < sites.size(); ++i)
    if (i != left_out) kept.push_back(i);
  return sites.subset(kept);
}

TEST_CASE("The closed form equals refits with each sample left out") {
  const int degree = GENERATE(-1, 0, 1);
  const double ridge = GENERATE(1e-4, 1e-1);
  MapSites sites = merge_samples(
      test::measure(test::glow_field, test::random_positions(40, 5), test::kFieldNoise, 1));
  sites.counts[3] = 4.0;
  TailBasis tail = tail_for(sites.positions);
  tail.degree = degree;
  const auto fit = fit_rbf(sites, tail, {KernelShape::kGaussian, 0.12, 0.0}, ridge);
  for (Eigen::Index i = 0; i < sites.size(); ++i) {
    const auto refit = fit_rbf(without(sites, i), tail, {KernelShape::kGaussian, 0.12, 0.0}, ridge);
    const Eigen::Vector2d p = sites.positions.col(i);
    const Eigen::Vector2d residual = sites.errors.col(i) - refit.map.predict(p).error;
    CHECK((fit.left_out.residuals.col(i) - residual).norm() <
          kShortcutRounding * sites.errors.norm());
    const double sigma = std::hypot(refit.map.unit_sigma(p), std::sqrt(ridge / sites.counts[i]));
    CHECK(fit.left_out.unit_sigmas[i] == Approx(sigma).epsilon(kShortcutRounding));
  }
}

}  // namespace
}  // namespace planar
