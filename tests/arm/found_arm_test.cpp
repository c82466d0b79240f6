#include "planar_servo/arm/found_arm.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

FoundArm bent_arm() {
  FoundArm arm;
  arm.link_lengths_m << 0.3004, 0.2993;
  arm.zero_offsets_rad << 2e-3, -1e-3, 4e-3;
  arm.harmonics.push_back({{0.5e-3, -0.8e-3, 1e-3}, {0.3e-3, 0.6e-3, -0.4e-3}});
  arm.harmonics.push_back({{0.1e-3, 0.2e-3, 0.0}, {-0.2e-3, 0.0, 0.1e-3}});
  return arm;
}

TEST_CASE("An output is the motor's angle, its zero and a wave of each order") {
  const double m = 0.7;
  const Eigen::Vector3d outputs = reducer_outputs(bent_arm(), {m, m, m});
  CHECK(outputs[0] == Approx(m + 2e-3 + 0.5e-3 * std::sin(m) + 0.3e-3 * std::cos(m) +
                             0.1e-3 * std::sin(2 * m) - 0.2e-3 * std::cos(2 * m)));
}

TEST_CASE("Motors for outputs undo the reducers") {
  for (const double turn : {-5.0, -0.3, 0.0, 2.0, 9.0}) {
    const Eigen::Vector3d wanted(turn, 0.5 * turn, 1.0 - turn);
    const Eigen::Vector3d motors = motors_for_outputs(bent_arm(), wanted);
    CHECK((reducer_outputs(bent_arm(), motors) - wanted).norm() < 1e-14);
  }
}

TEST_CASE("A plan for an arm that was found puts that arm on the target, in either sense") {
  for (const Rotation rotation : {Rotation::kCounterclockwise, Rotation::kClockwise}) {
    TransmissionSettings settings;
    for (Eigen::Vector2d& limits : settings.limits_rad) limits << -360 * kDegree, 360 * kDegree;
    const Transmission transmission(settings);
    JointPlanner planner(PlanarArm({{0.3, 0.3}, rotation}), transmission, {0.06, 0.54, {}},
                         Elbow::kLeft);
    const TipPose target{{0.21, -0.33}, 0.4};
    const Joints by_files = planner.plan(target, Joints::Zero()).theta;
    planner.plan_for(bent_arm());
    const JointPlan plan = planner.plan(target, Joints::Zero());
    REQUIRE_FALSE(plan.refusal);
    CHECK((plan.theta - by_files).norm() > 1e-3);
    // Relative motors: their outputs are differences of the joints.
    const Eigen::Vector3d o =
        reducer_outputs(bent_arm(), transmission.motors_from_joints(plan.theta));
    const double s = rotation == Rotation::kClockwise ? -1.0 : 1.0;
    const double a = s * o[0], b = s * (o[0] + o[1]), c = s * (o[0] + o[1] + o[2]);
    const Eigen::Vector2d p(0.3004 * std::cos(a) + 0.2993 * std::cos(b),
                            0.3004 * std::sin(a) + 0.2993 * std::sin(b));
    CHECK((p - target.p).norm() < 1e-12);
    CHECK(std::abs(wrap_angle(c - target.phi)) < 1e-12);
  }
}

TEST_CASE("The workspace holds for the target, whatever arm was found") {
  TransmissionSettings settings;
  for (Eigen::Vector2d& limits : settings.limits_rad) limits << -360 * kDegree, 360 * kDegree;
  JointPlanner planner(PlanarArm({{0.3, 0.3}, Rotation::kCounterclockwise}), Transmission(settings),
                       {0.06, 0.54, {}}, Elbow::kLeft);
  planner.plan_for(bent_arm());
  CHECK_FALSE(planner.plan({{0.5399, 0.0}, 0.0}, Joints::Zero()).refusal);
  CHECK(planner.plan({{0.5401, 0.0}, 0.0}, Joints::Zero()).refusal);
}

}  // namespace
}  // namespace planar
