#include "planar_servo/geometry/arm/transmission.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kAlgebra = 1e-14;  // some roundings of numbers near 1
// One pulse of these drives moves the tip by up to 4 um; a first step of 1 mm is linear to 5 um.
constexpr double kFirstStep_m = 15e-6;

TransmissionSettings settings_with(Coupling motor2, Coupling motor3) {
  TransmissionSettings settings;
  settings.coupling = {motor2, motor3};
  settings.drives[0] = {10000.0, 100.0, 1, 1.0, 5.0};
  settings.drives[1] = {10000.0, 80.0, -1, 1.0, 5.0};
  settings.drives[2] = {10000.0, 50.0, 1, 2.0, 10.0};
  settings.limits_rad = {Eigen::Vector2d(-3.0, 3.0), Eigen::Vector2d(-2.8, 2.8),
                         Eigen::Vector2d(-6.2, 6.2)};
  return settings;
}

Transmission make(Coupling motor2, Coupling motor3) {
  return Transmission(settings_with(motor2, motor3));
}

/// Where a counterclockwise arm with links of 0.3 m puts its tip when its motors have turned by
/// `n` pulses: written without the room's own kinematics.
Eigen::Vector2d tip_of_machine(const Pulses& n, bool relative) {
  const double m1 = n[0] * 2.0 * kPi / 1e6;
  const double m2 = -n[1] * 2.0 * kPi / 8e5;
  const double link2 = relative ? m1 + m2 : m2;
  return {0.3 * (std::cos(m1) + std::cos(link2)), 0.3 * (std::sin(m1) + std::sin(link2))};
}

}  // namespace

TEST_CASE("A motor that rides on the link before turns by the difference") {
  Eigen::Matrix3d relative;
  relative << 1, 0, 0, -1, 1, 0, 0, -1, 1;
  CHECK(make(Coupling::kRelative, Coupling::kRelative).coupling_matrix() == relative);
  CHECK(make(Coupling::kAbsolute, Coupling::kAbsolute).coupling_matrix().isIdentity());
  Eigen::Matrix3d mixed;
  mixed << 1, 0, 0, 0, 1, 0, 0, -1, 1;
  CHECK(make(Coupling::kAbsolute, Coupling::kRelative).coupling_matrix() == mixed);
}

TEST_CASE("Motor angles and joint angles are each other's inverse for every coupling") {
  const Joints theta{0.4, -1.7, 2.5};
  for (const Coupling motor2 : {Coupling::kRelative, Coupling::kAbsolute}) {
    for (const Coupling motor3 : {Coupling::kRelative, Coupling::kAbsolute}) {
      const Transmission transmission = make(motor2, motor3);
      const Joints back = transmission.joints_from_motors(transmission.motors_from_joints(theta));
      CHECK((back - theta).norm() < kAlgebra);
    }
  }
}

TEST_CASE("Pulses count gear, direction and coupling") {
  const double quarter = kPi / 2;
  const Pulses n = make(Coupling::kRelative, Coupling::kRelative)
                       .pulses_from_joints({quarter, 3 * quarter, 2 * quarter});
  CHECK(n == Pulses(250000, -400000, -125000));
}

TEST_CASE("Angles survive the way through pulses within half a pulse of each motor") {
  const Transmission transmission = make(Coupling::kRelative, Coupling::kRelative);
  for (int i = 0; i < 200; ++i) {
    const Joints theta{std::sin(1.0 * i), 2.0 * std::sin(2.0 * i), 3.0 * std::sin(3.0 * i)};
    const Pulses n = transmission.pulses_from_joints(theta);
    const Joints back = transmission.joints_from_pulses(n);
    const Eigen::Vector3d off_pulses =
        transmission.motors_from_joints(back - theta).cwiseProduct(transmission.pulses_per_rad());
    CHECK(off_pulses.cwiseAbs().maxCoeff() <= 0.5 + 1e-8);  // rounding of a million pulses
    CHECK(transmission.pulses_from_joints(back) == n);
  }
}

TEST_CASE("The first step of either coupling moves the tip where it was sent, not only the last") {
  const PlanarArm arm({{0.3, 0.3}, Rotation::kCounterclockwise});
  const Joints theta{0.5, 1.8, 0.0};
  for (const bool relative : {true, false}) {
    const Coupling coupling = relative ? Coupling::kRelative : Coupling::kAbsolute;
    const Transmission right = make(coupling, coupling);
    const Pulses start = right.pulses_from_joints(theta);
    for (int direction = 0; direction < 8; ++direction) {
      const Eigen::Vector2d dp = 1e-3 * rotation2d(direction * kPi / 4).col(0);
      Joints next = theta;
      next.head<2>() += arm.jacobian(theta).inverse() * dp;
      const Pulses end = right.pulses_from_joints(next);
      const Eigen::Vector2d moved = tip_of_machine(end, relative) - tip_of_machine(start, relative);
      CHECK((moved - dp).norm() < kFirstStep_m);
    }
  }
}

TEST_CASE("The Jacobian over relative joint angles is that of the robotics toolbox") {
  // petercorke/robotics-toolbox-python, TestERobot2.test_jacobe: Planar2 with links of 1 m at
  // q = (0, 0) has rows vx: 0 0, vy: 2 1, wz of link 2: 1 1.
  const PlanarArm arm({{1.0, 1.0}, Rotation::kCounterclockwise});
  const Transmission relative = make(Coupling::kRelative, Coupling::kRelative);
  Eigen::Matrix2d theta_per_q;
  theta_per_q.col(0) = relative.joints_from_motors(Eigen::Vector3d::UnitX()).head<2>();
  theta_per_q.col(1) = relative.joints_from_motors(Eigen::Vector3d::UnitY()).head<2>();
  Eigen::Matrix2d velocity;
  velocity << 0, 0, 2, 1;
  CHECK((arm.jacobian(Joints::Zero()) * theta_per_q).isApprox(velocity));
  CHECK(theta_per_q.row(1) == Eigen::RowVector2d(1, 1));
}

TEST_CASE("A broken limit is told in words, for every motor that breaks it") {
  const Transmission relative = make(Coupling::kRelative, Coupling::kAbsolute);
  CHECK_FALSE(relative.limit_violation({2.9, 2.9, 0.0}));
  CHECK_FALSE(relative.limit_violation({2.9, 5.6, 0.0}));  // the motor's angle counts: 2.7
  CHECK(*relative.limit_violation({0.0, 170 * kDegree, 0.0}) ==
        "motor 2 would turn to 170.000 deg; its limits are [-160.428, 160.428]");
  const std::string both = *relative.limit_violation({-3.1, -3.1, 7.0});
  CHECK_THAT(both, Catch::StartsWith("motor 1 would turn to -177.617 deg") &&
                       Catch::Contains("; motor 3 would turn to 401.070 deg"));
}

TEST_CASE("Among the turns of a motor the one within its limits and nearest is taken") {
  const Transmission transmission = make(Coupling::kRelative, Coupling::kRelative);
  const Joints pose(0.5, 1.0, 1.5);
  // Motor 3 may turn to +-6.2: near +6 the angle 0.5 stays, and -5.78 is nearer to -6.
  for (const double near3 : {6.0, -6.0}) {
    const auto found = transmission.branch_within_limits(pose, Joints(0.5, 1.0, 1.0 + near3), {});
    REQUIRE(found.has_value());
    CHECK((*found)[2] == Approx(near3 > 0 ? 1.5 : 1.5 - 2.0 * kPi));
  }
  // Whole turns of joint 1 are brought back, and the joints behind it with it, wherever it stands.
  for (const double turns : {-3.0, -1.0, 1.0, 3.0}) {
    const Joints turned = pose.array() + turns * 2.0 * kPi;
    for (const Joints& near : {pose, turned}) {
      const auto found = transmission.branch_within_limits(turned, near, {});
      REQUIRE(found.has_value());
      CHECK((*found - pose).norm() < 1e-12);
    }
  }
  // At -6.18 motor 3 is within its limit, but has no room of 0.05 left above it.
  const Joints low(0.5, 1.0, 1.0 - 6.18);
  CHECK((*transmission.branch_within_limits(low, low, {}) - low).norm() < 1e-12);
  CHECK((*transmission.branch_within_limits(low, low, {0.05, 0.0}))[2] ==
        Approx(low[2] + 2.0 * kPi));
  // Motor 1 stops at +-3: there is no turn on which it stands at 3.1.
  CHECK_FALSE(transmission.branch_within_limits(Joints(3.1, 3.1, 3.1), pose, {}).has_value());
}

TEST_CASE("The transmission refuses what is not finite or beyond 32 bits") {
  const Transmission transmission = make(Coupling::kRelative, Coupling::kRelative);
  const Joints bad{0.0, kNoNumber, 0.0};
  CHECK_THROWS_AS(transmission.motors_from_joints(bad), std::invalid_argument);
  CHECK_THROWS_AS(transmission.joints_from_motors(bad), std::invalid_argument);
  CHECK_THROWS_AS(transmission.pulses_from_joints(bad), std::invalid_argument);
  CHECK_THROWS_AS(transmission.limit_violation(bad), std::invalid_argument);
  CHECK_THROWS_AS(transmission.pulses_from_joints({1e5, 0.0, 0.0}), std::out_of_range);
}

TEST_CASE("The transmission refuses settings that break their rule, naming the motor") {
  const auto with = [](const auto& change) {
    TransmissionSettings settings = settings_with(Coupling::kRelative, Coupling::kRelative);
    change(settings);
    return Transmission(settings);
  };
  CHECK_THROWS_WITH(with([](auto& s) { s.drives[1].gear_ratio = 0.0; }),
                    Catch::StartsWith("motor 2: ") && Catch::Contains("must be positive"));
  CHECK_THROWS_WITH(with([](auto& s) { s.drives[2].pulses_per_motor_turn = kNoNumber; }),
                    Catch::StartsWith("motor 3: "));
  CHECK_THROWS_WITH(with([](auto& s) { s.drives[0].direction = 0; }),
                    Catch::StartsWith("motor 1: direction is 0"));
  CHECK_THROWS_WITH(with([](auto& s) {
                      s.limits_rad[2] = {1.0, 1.0};
                    }),
                    Catch::StartsWith("motor 3: limits [57.296, 57.296] deg"));
}

}  // namespace planar
