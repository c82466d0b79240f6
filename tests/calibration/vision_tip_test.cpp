#include "calibration/vision_tip.h"

#include <catch2/catch.hpp>

#include "core/units.h"
#include "synthetic_cell.h"

namespace planar {
namespace {

constexpr double kRoundTrip = 1e-10;  // m: the lens is inverted iteratively
constexpr double kSeparation = 0.04;

TEST_CASE("The end point seen through its lamps is the one they were placed from") {
  const test::SyntheticCell cell;
  ToolOffsets tool;
  tool.p_TP = {0.001, -0.002};
  const TipPose tip{{0.2, -0.1}, 2.5};
  const auto lamps = lamps_from_tip(cell.workplane(), tool, kSeparation, tip);
  REQUIRE(lamps.has_value());
  const std::array<Eigen::Matrix2d, 2> covariances{Eigen::Matrix2d::Identity() * 1e-4,
                                                   Eigen::Matrix2d::Identity() * 1e-4};
  const auto seen = tip_from_lamps(cell.workplane(), tool, *lamps, covariances);
  REQUIRE(seen.has_value());
  CHECK((seen->tip.p - tip.p).norm() < kRoundTrip);
  CHECK(seen->tip.phi == Approx(tip.phi).margin(1e-8));
  // Two lamps of 0.01 px each: their mean is 1/sqrt 2 of that, times the size of a pixel.
  const double pixel = kSeparation / ((*lamps)[1] - (*lamps)[0]).norm();
  CHECK(std::sqrt(0.5 * seen->covariance.trace()) ==
        Approx(0.01 / std::sqrt(2.0) * pixel).epsilon(0.05));
}

TEST_CASE("Swapped lamps turn the tool by half a turn") {
  const test::SyntheticCell cell;
  const ToolOffsets tool;
  const auto lamps = lamps_from_tip(cell.workplane(), tool, kSeparation, {{0.1, 0.3}, 0.5});
  REQUIRE(lamps.has_value());
  const std::array<Eigen::Matrix2d, 2> covariances{Eigen::Matrix2d::Zero(),
                                                   Eigen::Matrix2d::Zero()};
  const auto seen = tip_from_lamps(cell.workplane(), tool, {(*lamps)[1], (*lamps)[0]}, covariances);
  REQUIRE(seen.has_value());
  CHECK(seen->tip.phi == Approx(0.5 - kPi));
  CHECK((seen->tip.p - Eigen::Vector2d(0.1, 0.3)).norm() < kRoundTrip);
}

}  // namespace
}  // namespace planar
