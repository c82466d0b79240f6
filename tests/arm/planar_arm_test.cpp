#include "planar_servo/geometry/arm/planar_arm.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/units.h"
#include "support/finite_differences.h"

namespace planar {
namespace {

constexpr double kL1 = 0.3;
constexpr double kL2 = 0.25;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

constexpr double kAlgebra_m = 1e-14;  // some roundings of 0.3 m
// On the rim the elbow's angle moves as the root of the rounding of r: sqrt(epsilon).
constexpr double kAngleAtRim = 1e-7;
constexpr double kDifference_rad = 1e-3;
constexpr double kFiniteDifference = 1e-9;  // fourth order: step^4 and epsilon / step

PlanarArm make_arm(Rotation rotation, double L2 = kL2) {
  return PlanarArm({{kL1, L2}, rotation});
}

constexpr Rotation kRotations[] = {Rotation::kCounterclockwise, Rotation::kClockwise};
constexpr Elbow kElbows[] = {Elbow::kLeft, Elbow::kRight};

/// Calls `check` for targets from the inner to the outer rim, all round.
template <typename Check>
void over_the_annulus(const Check& check) {
  for (int i = 0; i <= 20; ++i) {
    const double r = (kL1 - kL2) + (2.0 * kL2) * i / 20.0;
    for (int k = 0; k < 36; ++k) {
      const double direction = 2.0 * kPi * k / 36.0;
      check(TipPose{{r * std::cos(direction), r * std::sin(direction)}, direction / 2.0});
    }
  }
}

}  // namespace

TEST_CASE("Joint angles are absolute and grow in the arm's own sense") {
  const Joints theta{0.0, kPi / 2, kPi / 3};
  const TipPose counterclockwise = make_arm(Rotation::kCounterclockwise).forward(theta);
  CHECK((counterclockwise.p - Eigen::Vector2d(kL1, kL2)).norm() < kAlgebra_m);
  CHECK(counterclockwise.phi == Approx(kPi / 3));
  const TipPose clockwise = make_arm(Rotation::kClockwise).forward(theta);
  CHECK((clockwise.p - Eigen::Vector2d(kL1, -kL2)).norm() < kAlgebra_m);
  CHECK(clockwise.phi == Approx(-kPi / 3));
}

TEST_CASE("Inverse kinematics returns to the target over the annulus in all four sign cases") {
  for (const Rotation rotation : kRotations) {
    for (const Elbow elbow : kElbows) {
      const PlanarArm arm = make_arm(rotation);
      over_the_annulus([&](const TipPose& target) {
        const InverseResult found = arm.inverse(target, elbow, Joints::Zero());
        REQUIRE(found.status == ReachStatus::kOk);
        const TipPose reached = arm.forward(found.theta);
        CHECK((reached.p - target.p).norm() < kAlgebra_m);
        CHECK(std::abs(wrap_angle(reached.phi - target.phi)) < kAlgebra_m);
      });
    }
  }
}

TEST_CASE("The elbow lies on the side asked for, seen from +Z") {
  for (const Rotation rotation : kRotations) {
    const PlanarArm arm = make_arm(rotation);
    const TipPose target{{-0.2, 0.3}, 0.0};
    for (const Elbow elbow : kElbows) {
      const Joints theta = arm.inverse(target, elbow, Joints::Zero()).theta;
      const Eigen::Vector2d p_elbow{kL1 * std::cos(theta[0]),
                                    arm.sense() * kL1 * std::sin(theta[0])};
      const double left_of_ray = target.p.x() * p_elbow.y() - target.p.y() * p_elbow.x();
      CHECK((left_of_ray > 0.0) == (elbow == Elbow::kLeft));
      CHECK(arm.elbow(theta) == elbow);
    }
  }
}

TEST_CASE("Inverse kinematics returns to the joints, turns included, when it starts near them") {
  for (const Rotation rotation : kRotations) {
    const PlanarArm arm = make_arm(rotation);
    for (const Joints& theta : {Joints(0.4, 1.9, -0.3), Joints(9.0, 7.5, 20.0),
                                Joints(-12.0, -13.0, -40.0), Joints(3.2, 3.0, 3.3)}) {
      const Joints near = theta + Joints(0.2, -0.2, 3.0);
      const InverseResult kept = arm.inverse(arm.forward(theta), arm.elbow(theta), near);
      CHECK((kept.theta - theta).norm() < kAngleAtRim);
    }
  }
}

TEST_CASE("A point that cannot be reached says why") {
  const PlanarArm arm = make_arm(Rotation::kCounterclockwise);
  const auto status = [](const PlanarArm& of, double x) {
    return of.inverse({{x, 0.0}, 0.0}, Elbow::kLeft, Joints::Zero()).status;
  };
  CHECK(status(arm, kL1 + kL2) == ReachStatus::kOk);
  CHECK(status(arm, kL1 + kL2 + 1e-6) == ReachStatus::kTooFar);
  CHECK(status(arm, kL1 - kL2) == ReachStatus::kOk);
  for (int i = 0; i < 360; ++i) {  // rounding may put a place of the rim beyond it
    const Eigen::Vector2d rim = (kL1 + kL2) * rotation2d(i * kDegree).col(0);
    CHECK(arm.inverse({rim, 0.0}, Elbow::kLeft, Joints::Zero()).status == ReachStatus::kOk);
  }
  CHECK(status(arm, kL1 - kL2 - 1e-6) == ReachStatus::kTooClose);
  CHECK(status(arm, 0.0) == ReachStatus::kTooClose);
  CHECK(status(make_arm(Rotation::kClockwise, kL1), 0.0) == ReachStatus::kUndetermined);
  CHECK_THAT(describe(ReachStatus::kTooFar), Catch::Contains("both links together"));
  CHECK_THAT(describe(ReachStatus::kTooClose), Catch::Contains("difference of the links"));
  CHECK_THAT(describe(ReachStatus::kUndetermined), Catch::Contains("not determined"));
}

TEST_CASE("The Jacobian of the arm agrees with finite differences in both senses") {
  for (const Rotation rotation : kRotations) {
    const PlanarArm arm = make_arm(rotation);
    const auto tip = [&](const Eigen::VectorXd& angles) -> Eigen::VectorXd {
      return arm.forward({angles[0], angles[1], 0.0}).p;
    };
    for (const Joints& theta :
         {Joints(0.3, 1.2, 0.0), Joints(-2.0, 1.0, 0.0), Joints(1.0, 1.0, 0.0)}) {
      const double mismatch =
          test::jacobian_mismatch(arm.jacobian(theta), tip, theta.head<2>(), kDifference_rad);
      CHECK(mismatch < kFiniteDifference);
      const double determinant = arm.jacobian(theta).determinant();
      CHECK(determinant ==
            Approx(arm.sense() * kL1 * kL2 * std::sin(theta[1] - theta[0])).margin(kAlgebra_m));
    }
  }
}

TEST_CASE("The arm is singular where its links are in line") {
  CHECK(PlanarArm::manipulability({0.4, 0.4 + kPi / 2, 0.0}) == Approx(1.0));
  CHECK(PlanarArm::manipulability({0.4, 0.4, 0.0}) == 0.0);
  CHECK(PlanarArm::manipulability({0.4, 0.4 + kPi, 0.0}) < kAlgebra_m);
}

TEST_CASE("The arm refuses numbers that are not finite") {
  CHECK_THROWS_AS(PlanarArm({{kNan, 0.3}, Rotation::kClockwise}), std::invalid_argument);
  CHECK_THROWS_AS(PlanarArm({{0.3, 0.0}, Rotation::kClockwise}), std::invalid_argument);
  const PlanarArm arm = make_arm(Rotation::kCounterclockwise);
  const Joints bad{0.1, kNan, 0.0};
  CHECK_THROWS_AS(arm.forward(bad), std::invalid_argument);
  CHECK_THROWS_AS(arm.jacobian(bad), std::invalid_argument);
  CHECK_THROWS_AS(arm.elbow(bad), std::invalid_argument);
  CHECK_THROWS_AS(PlanarArm::manipulability(bad), std::invalid_argument);
  const auto solve = [&](const TipPose& target, const Joints& near) {
    return arm.inverse(target, Elbow::kLeft, near);
  };
  CHECK_THROWS_AS(solve({{kNan, 0.3}, 0.0}, Joints::Zero()), std::invalid_argument);
  CHECK_THROWS_AS(solve({{0.3, 0.3}, kNan}, Joints::Zero()), std::invalid_argument);
  CHECK_THROWS_AS(solve({{0.3, 0.3}, 0.0}, bad), std::invalid_argument);
}

}  // namespace planar
