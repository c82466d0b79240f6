#include "planar_servo/error_map/judge/cross_validation.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/error_map/fit/rbf_families.h"
#include "planar_servo/error_map/fit/sparse_fit.h"
#include "planar_servo/error_map/fit_error_map.h"
#include "support/error_fields.h"

namespace planar {
namespace {

MapSites sites_of(const test::ErrorField& field, int count) {
  return merge_samples(
      test::measure(field, test::random_positions(count, 1), test::kFieldNoise, 1));
}

/// The same by fitting a map to the other blocks, one after the other.
double rms_of_refits(const MapSites& sites, const TunedFamily& family) {
  const Blocks blocks = spatial_blocks(sites.positions);
  double squares = 0.0;
  for (const auto& block : blocks) {
    std::vector<Eigen::Index> rest;
    for (Eigen::Index i = 0; i < sites.size(); ++i)
      if (std::find(block.begin(), block.end(), i) == block.end()) rest.push_back(i);
    const MapSites others = sites.subset(rest);
    const RbfFit fit = fit_rbf(others, tail_for(others.positions, family.tail_basis.degree),
                               family.tuned.kernel, family.tuned.ridge);
    for (const Eigen::Index i : block)
      squares +=
          (sites.errors.col(i) - fit.map.predict_error(sites.positions.col(i))).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(sites.size()));
}

constexpr double kRefitRounding = 1e-6;  // of stiff equations solved in another order

TEST_CASE("Each block is predicted by the map of the other blocks") {
  const MapSites sites = sites_of(test::glow_field, 100);
  const TunedFamily family = tune(sites, kManyScales);
  const CrossValidation found = cross_validate(fit_rbf(sites, family).map, sites);
  CHECK(found.rms.value == Approx(rms_of_refits(sites, family)).epsilon(kRefitRounding));
  CHECK(found.rms.low < found.rms.value);
  CHECK(found.rms.value < found.rms.high);
  CHECK(found.worth_using);
}

TEST_CASE("A sparse map's blocks are worth about what a dense one's are") {
  const MapSites sites = sites_of(test::bumpy_field, 700);
  const double dense = cross_validate(fit_rbf(sites, tune(sites, kSmooth)).map, sites).rms.value;
  const double sparse = cross_validate(fit_sparse(sites).map, sites).rms.value;
  CHECK(sparse == Approx(dense).epsilon(0.5));
}

TEST_CASE("A block is missed by more than one of its samples alone") {
  const auto samples =
      test::measure(test::bumpy_field, test::random_positions(200, 1), test::kFieldNoise, 1);
  const MapResult result = fit_error_map({samples});
  CHECK(result.blocked.value > result.loo_rms);
  CHECK(result.blocked.value < result.raw_rms);
  CHECK(result.worth_using);
}

TEST_CASE("Errors alike among neighbours only are not sold as a gain") {
  auto samples = test::measure(test::lens_field, test::random_positions(200, 1), 0.0, 1);
  const Blocks blocks = spatial_blocks(merge_samples(samples).positions);
  const auto noise = test::measure([](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); },
                                   test::random_positions(static_cast<int>(blocks.size()), 1),
                                   test::kFieldNoise, 3);
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (const Eigen::Index i : blocks[b])
      samples[static_cast<std::size_t>(i)].error = noise[b].error;
  CHECK_FALSE(fit_error_map({samples, MapMethod::kRbf}).worth_using);
}

}  // namespace
}  // namespace planar
