#include "planar_servo/learn/error_map/error_sample.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

TEST_CASE("The region is the hull of the samples and a margin of their spacing") {
  Eigen::Matrix2Xd positions(2, 9);
  positions << 0, 1, 2, 0, 1, 2, 0, 1, 2,  //
      0, 0, 0, 1, 1, 1, 2, 2, 2;
  const ValidRegion region = region_around(positions);
  CHECK(region.hull.size() == 4);
  CHECK(region.margin == 1.0);
  CHECK(region.contains({1.3, 0.7}));
  CHECK(region.contains({-0.9, 1.0}));
  CHECK_FALSE(region.contains({-1.1, 1.0}));
  CHECK(region.contains({2.6, 2.7}));        // 0.92 from the corner
  CHECK_FALSE(region.contains({2.8, 2.8}));  // 1.13 from the corner
  CHECK(region.nearest({1.3, 0.7}) == Eigen::Vector2d(1.3, 0.7));
  CHECK((region.nearest({5.0, 1.5}) - Eigen::Vector2d(3.0, 1.5)).norm() < 1e-12);
  CHECK((region.nearest({5.0, 6.0}) - Eigen::Vector2d(2.6, 2.8)).norm() < 1e-12);
}

TEST_CASE("Samples on a line are valid along the line and a margin beside it") {
  Eigen::Matrix2Xd positions(2, 4);
  positions << 0, 1, 2, 3, 0, 1, 2, 3;
  const ValidRegion region = region_around(positions);
  CHECK(region.hull.size() == 2);
  CHECK(region.contains({1.5, 1.5}));
  CHECK(region.contains({2.4, 0.6}));        // 1.27 beside the line, the spacing is 1.41
  CHECK_FALSE(region.contains({2.6, 0.4}));  // 1.56
}

}  // namespace
}  // namespace planar
