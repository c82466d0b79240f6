#include "planar_servo/learn/error_map/maps/rbf_map.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/learn/error_map/error_map.h"

namespace planar {
namespace {

IdwMap three_sample_map() {
  IdwMap map;
  map.centers.resize(2, 3);
  map.centers << 0.0, 1.0, 0.0, 0.0, 0.0, 2.0;
  map.errors.resize(2, 3);
  map.errors << 1e-3, 2e-3, 3e-3, 0.0, -1e-3, 5e-3;
  map.region = region_around(map.centers);
  return map;
}

TEST_CASE("Inverse distance weights are those of squared distances") {
  const IdwMap map = three_sample_map();
  const Eigen::Vector2d p(0.5, 0.0);  // squared distances 1/4, 1/4, 17/4
  const Eigen::Vector3d weights(4.0, 4.0, 4.0 / 17.0);
  const Eigen::Vector2d expected = map.errors * weights / weights.sum();
  CHECK((map.predict(p).error - expected).norm() < 1e-15);
  CHECK(std::isnan(map.predict(p).sigma));
}

TEST_CASE("At a sample, and as near as numbers go, the map has the sample's own value") {
  const IdwMap map = three_sample_map();
  CHECK(map.predict({1.0, 0.0}).error == map.errors.col(1));
  CHECK((map.predict({1e-170, 0.0}).error - map.errors.col(0)).norm() < 1e-15);
}

TEST_CASE("Leave-one-out residuals are those of maps without the sample") {
  const IdwMap map = three_sample_map();
  IdwMap others = map;
  others.centers = map.centers.rightCols(2);
  others.errors = map.errors.rightCols(2);
  const Eigen::Vector2d expected = map.errors.col(0) - others.predict(map.centers.col(0)).error;
  CHECK((leave_one_out_residuals(map).col(0) - expected).norm() < 1e-15);
}

TEST_CASE("A map is not evaluated at a position that is not finite") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(predict(three_sample_map(), {nan, 0.0}), std::invalid_argument);
}

}  // namespace
}  // namespace planar
