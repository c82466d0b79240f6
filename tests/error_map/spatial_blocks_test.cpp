#include "planar_servo/learn/error_map/cross_validation.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "support/error_fields.h"

namespace planar {
namespace {

MapSites sites_at(const std::vector<Eigen::Vector2d>& positions, std::uint32_t seed) {
  const auto nothing = [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); };
  return merge_samples(test::measure(nothing, positions, test::kFieldNoise, seed));
}

TEST_CASE("Every site is in one block, and blocks are alike in number and compact") {
  const MapSites sites = sites_at(test::random_positions(203, 1), 1);
  const Blocks blocks = spatial_blocks(sites.positions);
  REQUIRE(blocks.size() == 20);
  std::set<Eigen::Index> seen;
  for (const auto& block : blocks) {
    seen.insert(block.begin(), block.end());
    CHECK(std::abs(static_cast<int>(block.size()) - 10) <= 1);
    const Eigen::Matrix2Xd here = sites.positions(Eigen::all, block);
    const Eigen::Vector2d extent = here.rowwise().maxCoeff() - here.rowwise().minCoeff();
    CHECK(extent.maxCoeff() < test::kFieldRadius);  // a quarter of the square around the disc
  }
  CHECK(seen.size() == 203);
}

TEST_CASE("Few sites make few blocks, three make three") {
  CHECK(spatial_blocks(sites_at(test::random_positions(40, 1), 1).positions).size() == 8);
  CHECK(spatial_blocks(sites_at(test::random_positions(12, 1), 1).positions).size() == 5);
  CHECK(spatial_blocks(sites_at(test::random_positions(3, 1), 1).positions).size() == 3);
}

TEST_CASE("Student's t is that of the tables") {
  CHECK(student_t_95(4) == Approx(2.776).epsilon(0.005));
  CHECK(student_t_95(10) == Approx(2.228).epsilon(0.001));
  CHECK(student_t_95(19) == Approx(2.093).epsilon(0.001));
}

/// How many of 400 draws have the true rms of |E| in their interval.
template <typename Error>
double share_covered(double true_rms, Error error_of) {
  constexpr int kDraws = 400;
  const auto positions = test::random_positions(200, 1);
  int covered = 0;
  for (std::uint32_t seed = 1; seed <= kDraws; ++seed) {
    MapSites sites = sites_at(positions, seed);
    const Blocks blocks = spatial_blocks(sites.positions);
    sites.errors = error_of(sites.errors, blocks);
    const RmsEstimate estimate = estimate_rms(sites, sites.errors, blocks);
    if (estimate.low <= true_rms && true_rms <= estimate.high) ++covered;
  }
  return covered / static_cast<double>(kDraws);
}

// Four standard errors of a share of 95 % among 400 draws.
constexpr double kShareMargin = 0.044;

TEST_CASE("The interval of an rms holds the true one in about 95 of 100 cases") {
  const double rms = std::sqrt(2.0) * test::kFieldNoise;
  CHECK(share_covered(rms, [](const auto& errors, const Blocks&) { return errors; }) ==
        Approx(0.95).margin(kShareMargin));
}

TEST_CASE("Neighbours that are wrong together do not narrow the interval") {
  const double rms = std::sqrt(2.0) * test::kFieldNoise;
  const auto as_the_first = [](Eigen::Matrix2Xd errors, const Blocks& blocks) {
    for (const auto& block : blocks)
      for (const Eigen::Index i : block) errors.col(i) = errors.col(block.front()).eval();
    return errors;
  };
  CHECK(share_covered(rms, as_the_first) == Approx(0.95).margin(kShareMargin));
}

TEST_CASE("A sum over blocks is clearly positive only beyond its uncertainty") {
  CHECK(is_clearly_positive(Eigen::ArrayXd::LinSpaced(5, 1.0, 2.0)));
  CHECK(is_clearly_positive(
      (Eigen::ArrayXd(8) << 9.0, 0.1, 0.2, 0.1, 4.0, 0.3, 0.1, 0.2).finished()));
  CHECK_FALSE(is_clearly_positive(Eigen::ArrayXd::LinSpaced(5, -1.0, 1.5)));
  CHECK_FALSE(is_clearly_positive(Eigen::ArrayXd::Constant(2, 1.0)));
}

}  // namespace
}  // namespace planar
