#include "planar_servo/geometry/arm/found_arm.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/arm/joint_planner.h"
#include "support/finite_differences.h"

namespace planar {
namespace {

TransmissionSettings free_motors() {
  TransmissionSettings settings;
  for (Eigen::Vector2d& limits : settings.limits_rad) limits << -360 * kDegree, 360 * kDegree;
  settings.drives[1].gear_ratio = 80.0;
  settings.drives[2].gear_ratio = 50.0;
  return settings;
}

/// An arm with two harmonics behind its gears and nothing else.
FoundArm bent_arm() {
  FoundArm arm;
  arm.form.harmonics = 2;
  arm.x.resize(arm.form.terms());
  arm.x << 0.3004, 0.2993, 2e-3, -1e-3, 4e-3,          //
      0.5e-3, -0.8e-3, 1e-3, 0.3e-3, 0.6e-3, -0.4e-3,  //
      0.1e-3, 0.2e-3, 0.0, -0.2e-3, 0.0, 0.1e-3,       //
      0.0, 0.0;
  return arm;
}

/// The same with ripples of 1.5' and 0.5', a runout, and a deviation of some 10 um.
FoundArm waving_arm() {
  const FoundArm bent = bent_arm();
  FoundArm arm = bent;
  arm.form.ripples = 2;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(-kPi, kPi), weight(-10e-6, 10e-6);
  std::vector<Joints> postures;
  for (int i = 0; i < 300; ++i) {
    const double first = angle(random);
    postures.emplace_back(first, first + angle(random), 0.0);
  }
  arm.form.posture = basis_over_postures(postures, 0.6);
  arm.x.setZero(arm.form.terms());
  arm.x.head<17>() = bent.x.head<17>();
  arm.x.segment<12>(17) << 0.4e-3, -0.3e-3, 0.2e-3, 0.1e-3, 0.3e-3, -0.4e-3,  //
      0.1e-3, 0.1e-3, -0.1e-3, 0.1e-3, -0.1e-3, 0.0;
  arm.x.segment<2>(arm.form.runout()) << 6e-6, -4e-6;
  for (Eigen::Index i = arm.form.deviation(); i < arm.x.size(); ++i) arm.x[i] = weight(random);
  return arm;
}

TEST_CASE("An output is the motor's angle, its zero and a wave of each order") {
  FoundArm arm = bent_arm();
  const double m = 0.7;
  arm.x.head<2>() << 1.0, 0.0;  // so that the end point tells the output of motor 1
  const TipPose tip = arm.tip({m, m, m});
  CHECK(std::atan2(tip.p.y(), tip.p.x()) ==
        Approx(m + 2e-3 + 0.5e-3 * std::sin(m) + 0.3e-3 * std::cos(m) + 0.1e-3 * std::sin(2 * m) -
               0.2e-3 * std::cos(2 * m)));
  CHECK(tip.phi ==
        Approx(m + 4e-3 + 1e-3 * std::sin(m) - 0.4e-3 * std::cos(m) + 0.1e-3 * std::cos(2 * m)));
}

TEST_CASE("A plan for an arm that was found puts that arm on the target, in either sense") {
  for (const Rotation rotation : {Rotation::kCounterclockwise, Rotation::kClockwise}) {
    const Transmission transmission(free_motors());
    JointPlanner planner(PlanarArm({{0.3, 0.3}, rotation}), transmission, {0.06, 0.54, {}},
                         Elbow::kLeft);
    const TipPose target{{0.21, -0.33}, 0.4};
    const Joints by_files = planner.plan(target, Joints::Zero()).theta;
    planner.plan_for(bent_arm());
    const JointPlan plan = planner.plan(target, Joints::Zero());
    REQUIRE_FALSE(plan.refusal);
    CHECK((plan.theta - by_files).norm() > 1e-3);
    // Relative motors: their outputs are differences of the joints.
    const Eigen::Array3d m = transmission.motors_from_joints(plan.theta);
    const Eigen::VectorXd x = bent_arm().x;
    const Eigen::Array3d o = m + x.segment<3>(2).array() + x.segment<3>(5).array() * m.sin() +
                             x.segment<3>(8).array() * m.cos() +
                             x.segment<3>(11).array() * (2.0 * m).sin() +
                             x.segment<3>(14).array() * (2.0 * m).cos();
    const double s = rotation == Rotation::kClockwise ? -1.0 : 1.0;
    const double a = s * o[0], b = s * (o[0] + o[1]), c = s * (o[0] + o[1] + o[2]);
    const Eigen::Vector2d p(0.3004 * std::cos(a) + 0.2993 * std::cos(b),
                            0.3004 * std::sin(a) + 0.2993 * std::sin(b));
    CHECK((p - target.p).norm() < 1e-12);
    CHECK(std::abs(wrap_angle(c - target.phi)) < 1e-12);
  }
}

TEST_CASE("Where commanded joints lead undoes the plan, with ripple, runout and deviation, too") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> radius(0.12, 0.52), angle(-kPi, kPi);
  for (const Rotation rotation : {Rotation::kCounterclockwise, Rotation::kClockwise}) {
    JointPlanner planner(PlanarArm({{0.3, 0.3}, rotation}), Transmission(free_motors()),
                         {0.06, 0.54, {}}, Elbow::kLeft);
    planner.plan_for(waving_arm());
    for (int i = 0; i < 50; ++i) {
      const double r = radius(random), direction = angle(random);
      const TipPose target{{r * std::cos(direction), r * std::sin(direction)}, angle(random)};
      const JointPlan plan = planner.plan(target, Joints::Zero());
      REQUIRE_FALSE(plan.refusal);
      const TipPose reached = planner.reached(plan.theta);
      CHECK((reached.p - target.p).norm() < 1e-9);
      CHECK(std::abs(wrap_angle(reached.phi - target.phi)) < 1e-8);
      CHECK((planner.arm().forward(plan.theta).p - target.p).norm() > 1e-5);
    }
  }
}

TEST_CASE("A plan for a found arm reaches its target or is refused, however odd that arm is") {
  FoundArm odd = waving_arm();
  odd.x.segment<6>(ArmForm::kFirstWave + Eigen::Index{6} * odd.form.harmonics).setConstant(0.03);
  JointPlanner planner(PlanarArm({{0.3, 0.3}, Rotation::kCounterclockwise}),
                       Transmission(free_motors()), {0.06, 0.54, {}}, Elbow::kLeft);
  planner.plan_for(odd);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> radius(0.12, 0.52), angle(-kPi, kPi);
  int refused = 0;
  for (int i = 0; i < 100; ++i) {
    const double r = radius(random), direction = angle(random);
    const TipPose target{{r * std::cos(direction), r * std::sin(direction)}, angle(random)};
    const JointPlan plan =
        planner.plan_as_found(target, {direction, direction + 1.0, 0.0}, Elbow::kLeft);
    if (plan.refusal) {
      ++refused;
      continue;
    }
    const TipPose reached = planner.reached(plan.theta);
    CHECK((reached.p - target.p).norm() < 1e-5);
    CHECK(std::abs(wrap_angle(reached.phi - target.phi)) < 1e-5);
  }
  CHECK(refused > 0);
}

TEST_CASE("An arm's derivatives by every term agree with finite differences") {
  FoundArm arm = waving_arm();
  arm.form.joints_per_motor << 1, 0, 0, 1, 1, 0, 1, 1, 1;
  arm.form.gear_ratios << 100.0, 80.0, 50.0;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  for (const double sense : {1.0, -1.0}) {
    arm.form.sense = sense;
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d motors{angle(random), angle(random), angle(random)};
      const auto at = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
        const TipPose tip = arm.form.tip(motors, x);
        return Eigen::Vector3d(tip.p.x(), tip.p.y(), tip.phi);
      };
      const Eigen::MatrixXd J = arm.form.jacobian(motors, arm.x),
                            expected = test::numeric_jacobian(at, arm.x, 1e-4);
      REQUIRE(J.cols() == arm.form.terms());
      // The runout's turn with the directions is left out: 7 um, where links are 0.3 m.
      CHECK((J - expected).colwise().norm().maxCoeff() < 3e-5);
      CHECK(J.rightCols(2 * arm.form.posture.terms()).maxCoeff() > 0.1);
    }
  }
}

TEST_CASE("A ripple repeats with each turn of its motor, and not with half of one") {
  for (int motor = 0; motor < 3; ++motor) {
    FoundArm arm;
    arm.form.gear_ratios << 100.0, 80.0, 50.0;
    arm.form.ripples = 1;
    arm.x.setZero(arm.form.terms());
    arm.x.head<2>() << 0.3, 0.3;
    FoundArm smooth = arm;
    arm.x[ArmForm::kFirstWave + motor] = 1e-3;
    const auto ripple = [&](double turns) {
      Eigen::Vector3d motors(0.3, 0.4, 0.5);
      motors[motor] += turns * 2.0 * kPi / arm.form.gear_ratios[motor];
      const TipPose with = arm.tip(motors), without = smooth.tip(motors);
      return motor == 2 ? with.phi - without.phi
                        : (rotation2d(-motors[motor]) * (with.p - without.p)).y();
    };
    REQUIRE(std::abs(ripple(0.0)) > 1e-5);
    CHECK(ripple(1.0) == Approx(ripple(0.0)).epsilon(1e-3));
    CHECK(ripple(0.5) == Approx(-ripple(0.0)).epsilon(1e-3));
  }
}

TEST_CASE("A whole turn of joint 1 leads back to the same posture, half a turn does not") {
  const PostureBasis basis = basis_over_postures({{0.2, 1.1, 0.0}, {2.2, 3.0, 0.5}}, 0.6);
  REQUIRE(basis.terms() == 2);
  const Joints here(0.4, 1.0, 0.3), turn(2.0 * kPi, 2.0 * kPi, 0.0);
  CHECK((basis.at(here + turn) - basis.at(here)).norm() < 1e-12);
  CHECK((basis.at(here + 0.5 * turn) - basis.at(here)).norm() > 0.3);
  CHECK(basis.at({0.2, 1.1, -2.0})[0] == Approx(1.0));  // joint 3 does not matter
}

TEST_CASE("Centres over postures lie apart, and every posture is near one") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> angle(-kPi, kPi), elbow(0.5, 2.5);
  std::vector<Joints> postures;
  for (int i = 0; i < 500; ++i) {
    const double first = angle(random);
    postures.emplace_back(first, first + elbow(random), 0.0);
  }
  const PostureBasis basis = basis_over_postures(postures, 0.6);
  CHECK(basis.terms() >= 15);
  CHECK(basis.terms() <= 80);
  for (Eigen::Index i = 0; i < basis.terms(); ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      CHECK((basis.centers.col(i) - basis.centers.col(j)).norm() > 0.45);
  for (const Joints& posture : postures)  // three quarters of a width away and no farther
    CHECK(basis.at(posture).maxCoeff() > std::exp(-0.5 * 0.75 * 0.75) - 1e-12);
  CHECK(basis_over_postures({}, 0.6).terms() == 0);
}

TEST_CASE("The workspace holds for the target, whatever arm was found") {
  JointPlanner planner(PlanarArm({{0.3, 0.3}, Rotation::kCounterclockwise}),
                       Transmission(free_motors()), {0.06, 0.54, {}}, Elbow::kLeft);
  planner.plan_for(bent_arm());
  CHECK_FALSE(planner.plan({{0.5399, 0.0}, 0.0}, Joints::Zero()).refusal);
  CHECK(planner.plan({{0.5401, 0.0}, 0.0}, Joints::Zero()).refusal);
}

}  // namespace
}  // namespace planar
