#include "planar_servo/loop/servo/position_servo.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/units.h"
#include "support/finite_differences.h"

namespace planar {
namespace {

constexpr double kRounding = 1e-12;  // of ViSP's pseudo-inverse, radians

struct SignCase {
  Rotation rotation;
  Joints theta;  ///< with either elbow
};

const SignCase kSignCases[] = {
    {Rotation::kCounterclockwise, {0.4, 1.9, 0.0}},
    {Rotation::kCounterclockwise, {1.9, 0.4, 0.0}},
    {Rotation::kClockwise, {0.4, 1.9, 0.0}},
    {Rotation::kClockwise, {1.9, 0.4, 0.0}},
};

PlanarArm make_arm(Rotation rotation) {
  return PlanarArm({{0.3, 0.25}, rotation});
}

LawInput input_with_error(const PlanarArm& arm, const Joints& theta, const Eigen::Vector2d& dp) {
  const Eigen::Vector2d p = arm.forward(theta).p;
  return {theta, p, p + dp};
}

/// The distance left when the arm, being as its model says, takes the step.
double distance_left(const PlanarArm& arm, const LawInput& input, const LawStep& step) {
  Joints moved = input.theta;
  moved.head<2>() += step.delta_theta;
  return (arm.forward(moved).p - input.p_d).norm();
}

}  // namespace

TEST_CASE("The Jacobian law's first step is the adaptive gain times the numeric inverse") {
  for (const SignCase& sign : kSignCases) {
    const PlanarArm arm = make_arm(sign.rotation);
    const Eigen::Vector2d dp{0.7e-3, -1.1e-3};
    const auto tip = [&](const Eigen::VectorXd& angles) -> Eigen::VectorXd {
      return arm.forward({angles[0], angles[1], 0.0}).p;
    };
    const Eigen::Matrix2d J = test::numeric_jacobian(tip, sign.theta.head<2>(), 1e-3);
    const Eigen::Vector2d newton = J.inverse() * dp;
    for (const double gain : {1.0, 0.4}) {
      const LawStep step = jacobian_law(arm, input_with_error(arm, sign.theta, dp), gain);
      REQUIRE(step.status == LawStatus::kOk);
      const double x = newton.cwiseAbs().maxCoeff();
      const double lambda = gain / 2.0 * (1.0 + std::exp(-2.0 * x));
      // The finite differences are good to 1e-9 of a step of 0.01 rad.
      CHECK((step.delta_theta - lambda * newton).norm() < 1e-10);
    }
  }
}

TEST_CASE("The inverse law's first step is the difference of the closed forms") {
  for (const SignCase& sign : kSignCases) {
    const PlanarArm arm = make_arm(sign.rotation);
    const Joints desired = sign.theta + Joints(0.05, -0.03, 0.0);
    const LawInput input{sign.theta, arm.forward(sign.theta).p, arm.forward(desired).p};
    const LawStep step = inverse_law(arm, input, 1.0);
    REQUIRE(step.status == LawStatus::kOk);
    CHECK((step.delta_theta - Eigen::Vector2d(0.05, -0.03)).norm() < kRounding);
    CHECK(distance_left(arm, input, step) < kRounding);
    const Eigen::Vector2d halved = inverse_law(arm, input, 0.5).delta_theta;
    CHECK((halved - step.delta_theta / 2.0).norm() < kRounding);
  }
}

TEST_CASE("Both laws leave only the second order of a step") {
  for (const SignCase& sign : kSignCases) {
    const PlanarArm arm = make_arm(sign.rotation);
    for (int direction = 0; direction < 8; ++direction) {
      const Eigen::Vector2d dp = 1e-4 * rotation2d(direction * kPi / 4).col(0);
      const LawInput input = input_with_error(arm, sign.theta, dp);
      CHECK(distance_left(arm, input, jacobian_law(arm, input, 1.0)) < 0.01 * dp.norm());
      CHECK(distance_left(arm, input, inverse_law(arm, input, 1.0)) < kRounding);
    }
  }
}

TEST_CASE("Successive Jacobian steps use the present Jacobian, not an old one") {
  const PlanarArm arm = make_arm(Rotation::kClockwise);
  LawInput input = input_with_error(arm, {0.4, 1.9, 0.0}, {-0.05, 0.06});
  for (int i = 0; i < 8; ++i) {
    input.p = arm.forward(input.theta).p;
    input.theta.head<2>() += jacobian_law(arm, input, 1.0).delta_theta;
  }
  CHECK((arm.forward(input.theta).p - input.p_d).norm() < 1e-9);
}

TEST_CASE("Near a singularity both laws refuse and say so") {
  const PlanarArm arm = make_arm(Rotation::kCounterclockwise);
  for (const double bend : {0.0, 2.0 * kDegree, kPi - 2.0 * kDegree}) {
    const LawInput input = input_with_error(arm, {0.5, 0.5 + bend, 0.0}, {-1e-3, 0.0});
    CHECK(jacobian_law(arm, input, 1.0).status == LawStatus::kSingular);
    CHECK(inverse_law(arm, input, 1.0).status == LawStatus::kSingular);
  }
  const LawInput bent = input_with_error(arm, {0.5, 0.5 + 4.0 * kDegree, 0.0}, {-1e-6, 0.0});
  CHECK(jacobian_law(arm, bent, 1.0).status == LawStatus::kOk);
  CHECK_THAT(describe(LawStatus::kSingular), Catch::Contains("straight or folded"));
}

TEST_CASE("The inverse law refuses points out of reach") {
  const PlanarArm arm = make_arm(Rotation::kCounterclockwise);
  CHECK(inverse_law(arm, {{0.1, 1.5, 0.0}, {0.56, 0.0}, {0.3, 0.0}}, 1.0).status ==
        LawStatus::kUnreachable);
  CHECK(inverse_law(arm, {{0.1, 1.5, 0.0}, {0.3, 0.0}, {0.56, 0.0}}, 1.0).status ==
        LawStatus::kUnreachable);
}

}  // namespace planar
