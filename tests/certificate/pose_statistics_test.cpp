#include "planar_servo/certificate/cell_accuracy.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

namespace planar {
namespace {

/// Three times as wide as high, about zero: distances 3, 3, 1, 1 from the barycentre.
const PoseErrors kCloud{{3e-6, 0.0}, {-3e-6, 0.0}, {0.0, 1e-6}, {0.0, -1e-6}};

PoseErrors moved(PoseErrors errors, const Eigen::Vector2d& by) {
  for (Eigen::Vector2d& error : errors) error += by;
  return errors;
}

TEST_CASE("RP is the mean distance and three deviations over n - 1") {
  const PoseAccuracy found = pose_accuracy(kCloud);
  CHECK(found.accuracy == Approx(0.0).margin(1e-18));
  CHECK(found.repeatability == Approx((2.0 + 3.0 * std::sqrt(4.0 / 3.0)) * 1e-6));
}

TEST_CASE("A constant offset moves AP by its length and leaves RP") {
  const PoseAccuracy found = pose_accuracy(moved(kCloud, {3e-6, -4e-6}));
  CHECK(found.accuracy == Approx(5e-6));
  CHECK(found.repeatability == Approx(pose_accuracy(kCloud).repeatability));
}

TEST_CASE("Twice the scatter is twice the RP") {
  PoseErrors wide = kCloud;
  for (Eigen::Vector2d& error : wide) error *= 2.0;
  CHECK(pose_accuracy(wide).repeatability == Approx(2.0 * pose_accuracy(kCloud).repeatability));
}

TEST_CASE("An angle's AP is its mean and its RP three deviations") {
  const PoseAccuracy found = angle_accuracy({-1e-3, -2e-3, -3e-3});
  CHECK(found.accuracy == Approx(2e-3));
  CHECK(found.repeatability == Approx(3e-3));
}

TEST_CASE("vAP is the greatest distance between barycentres, wherever they lie") {
  const std::vector<PoseErrors> directions{kCloud, moved(kCloud, {3e-6, 4e-6}),
                                           moved(kCloud, {0.0, 1e-6})};
  CHECK(direction_variation(directions) == Approx(5e-6));
  std::vector<PoseErrors> offset;
  for (const PoseErrors& errors : directions) offset.push_back(moved(errors, {1e-3, 0.0}));
  CHECK(direction_variation(offset) == Approx(5e-6));
}

TEST_CASE("One error has no RP and none has no AP") {
  CHECK(std::isnan(pose_accuracy({{1e-6, 0.0}}).repeatability));
  CHECK(pose_accuracy({{1e-6, 0.0}}).accuracy == Approx(1e-6));
  CHECK_THROWS_AS(pose_accuracy({}), std::invalid_argument);
}

}  // namespace
}  // namespace planar
