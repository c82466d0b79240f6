#include "planar_servo/geometry/arm/joint_planner.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

JointPlanner make_planner(Elbow elbow) {
  TransmissionSettings settings;
  settings.limits_rad = {Eigen::Vector2d(-175, 175) * kDegree, Eigen::Vector2d(-165, 165) * kDegree,
                         Eigen::Vector2d(-360, 360) * kDegree};
  return JointPlanner(PlanarArm({{0.3, 0.3}, Rotation::kCounterclockwise}), Transmission(settings),
                      {0.06, 0.54, {}}, elbow);
}

TipPose at(double r, double direction) {
  return {{r * std::cos(direction), r * std::sin(direction)}, 0.0};
}

}  // namespace

TEST_CASE("A plan has the planner's elbow and reaches its target") {
  for (const Elbow elbow : {Elbow::kLeft, Elbow::kRight}) {
    const JointPlanner planner = make_planner(elbow);
    const JointPlan plan = planner.plan(at(0.4, 1.0), Joints::Zero());
    REQUIRE_FALSE(plan.refusal);
    CHECK(planner.arm().elbow(plan.theta) == elbow);
    CHECK((planner.arm().forward(plan.theta).p - at(0.4, 1.0).p).norm() < 1e-14);
  }
}

TEST_CASE("Round the base the plan unwinds a motor rather than leave its limits") {
  const JointPlanner planner = make_planner(Elbow::kRight);
  Joints near = Joints::Zero();
  bool unwound = false;
  for (int i = 0; i <= 80; ++i) {
    const JointPlan plan = planner.plan(at(0.4, (-200 + 5.0 * i) * kDegree), near);
    if (plan.refusal) {  // joint 1 may not point within 5 deg of the negative x axis
      CHECK_THAT(*plan.refusal, Catch::Contains("motor 1 would turn to"));
      continue;
    }
    unwound = unwound || std::abs(plan.theta[0] - near[0]) > kPi;
    near = plan.theta;
  }
  CHECK(unwound);
}

TEST_CASE("A plan leaves room for corrections between a motor and its limits") {
  const JointPlanner planner = make_planner(Elbow::kRight);
  const auto motors = [&](const Joints& theta) {
    return planner.transmission().motors_from_joints(theta);
  };
  Joints near = planner.plan(at(0.4, 1.0), Joints::Zero()).theta;
  for (const double limit : {-360.0 * kDegree, 360.0 * kDegree}) {
    const double toward_zero = limit > 0.0 ? -1.0 : 1.0;
    near[2] += limit - motors(near)[2];  // motor 3 stands at its limit
    TipPose target = at(0.4, 1.0);
    target.phi = planner.arm().forward(near).phi;
    const JointPlan plan = planner.plan(target, near);
    REQUIRE_FALSE(plan.refusal);
    CHECK(motors(plan.theta)[2] == Approx(limit + 2.0 * kPi * toward_zero).margin(1e-9));
  }
}

TEST_CASE("A plan is refused with its reason: reach, workspace or motor limits") {
  const JointPlanner planner = make_planner(Elbow::kLeft);
  CHECK_THAT(*planner.plan(at(0.7, 0.0), Joints::Zero()).refusal,
             Catch::Contains("both links together"));
  CHECK_THAT(*planner.plan(at(0.55, 0.0), Joints::Zero()).refusal,
             Catch::Contains("the workspace reaches"));
  CHECK_THAT(*planner.refusal({3.1, 1.5, 0.0}), Catch::Contains("motor 1 would turn to 177.617"));
  CHECK_FALSE(planner.refusal({1.0, 2.5, 0.0}));
}

TEST_CASE("A plan refuses numbers that are not finite") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const JointPlanner planner = make_planner(Elbow::kLeft);
  CHECK_THROWS_AS(planner.plan(at(nan, 0.0), Joints::Zero()), std::invalid_argument);
  CHECK_THROWS_AS(planner.refusal({0.0, nan, 0.0}), std::invalid_argument);
}

}  // namespace planar
