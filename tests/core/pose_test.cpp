#include "planar_servo/base/core/pose.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kRounding = 1e-14;

TEST_CASE("Wrapped angles lie above -pi, at most at pi, and differ by whole turns") {
  CHECK(wrap_angle(kPi) == Approx(kPi));
  CHECK(wrap_angle(-kPi) == Approx(kPi));
  CHECK(wrap_angle(7.0) == Approx(7.0 - 2.0 * kPi));
}

TEST_CASE("The nearest branch stays within half a turn of its reference") {
  CHECK(nearest_branch(-kPi + 0.1, kPi) == Approx(kPi + 0.1));
  CHECK(nearest_branch(0.3, 20.0 * kPi) == Approx(20.0 * kPi + 0.3));
}

TEST_CASE("Rotations turn x to y") {
  CHECK((rotation2d(kPi / 2) * Eigen::Vector2d::UnitX() - Eigen::Vector2d::UnitY()).norm() <
        kRounding);
  const Eigen::Matrix3d R = rotation_from_vector({0.0, 0.0, kPi / 2});
  CHECK((R * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm() < kRounding);
  CHECK(rotation_from_vector(Eigen::Vector3d::Zero()).isIdentity());
}

}  // namespace
}  // namespace planar
