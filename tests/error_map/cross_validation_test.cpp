#include "planar_servo/learn/error_map/cross_validation.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/learn/error_map/fit/rbf_fit.h"
#include "planar_servo/learn/error_map/fit/sparse_fit.h"
#include "planar_servo/learn/error_map/fit_error_map.h"
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

TEST_CASE("The gap that is judged is as wide as a block leaves it") {
  constexpr double kPitch = 0.010;
  std::vector<Eigen::Vector2d> grid;
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j) grid.emplace_back(kPitch * i, kPitch * j);
  const MapSites sites = merge_samples(test::measure(test::lens_field, grid, 1e-5, 1));
  const double gap = cross_validate(fit_rbf(sites, tune(sites, kOneWidth)).map, sites).gap;
  CHECK(gap >= 4.0 * kPitch);  // blocks have four times five sites
  CHECK(gap <= 8.0 * kPitch);
}

TEST_CASE("A map that serves between its places is worth using, though not in gaps") {
  const auto waves = [](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(0.1e-3 * std::sin(p.x() / 0.032), 0.1e-3 * std::sin(p.y() / 0.032));
  };
  const MapResult result =
      fit_error_map({test::measure(waves, test::ring_positions(800), test::kFieldNoise, 1)});
  CHECK(result.worth_using);
  CHECK(result.gain() > 0.5);
  CHECK(result.blocked.value > 0.8 * result.raw_rms);
}

}  // namespace
}  // namespace planar
