#include "planar_servo/virtual_cell/motion/virtual_arm.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "planar_servo/virtual_cell/virtual_clock.h"
#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

constexpr double kHalfPulseRad = 0.5 * 2.0 * kPi / 5e5;  // of joint 3, the coarsest
constexpr double kReachM = 1.2;                          // both links and their sensitivities

Truth ideal_truth() {
  Truth truth;
  truth.tool.lamps_m = {Eigen::Vector2d(-0.02, 0.0), Eigen::Vector2d(0.02, 0.0)};
  truth.tool.lamp_height_m = 0.005;
  return truth;
}

/// Sends the joints to theta by the coupling of the motors, m = C theta.
void drive_to(VirtualArm& arm, const VirtualHardware& hardware, const Eigen::Vector3d& theta,
              VirtualClock& clock) {
  const auto& [two_rides, three_rides] = hardware.relative;
  const Eigen::Vector3d m(theta[0], theta[1] - (two_rides ? theta[0] : 0.0),
                          theta[2] - (three_rides ? theta[1] : 0.0));
  for (int joint = 0; joint < 3; ++joint) {
    arm.drive(joint).energize();
    arm.drive(joint).set_target(
        static_cast<std::int32_t>(std::lround(hardware.pulses_per_rad()[joint] * m[joint])));
  }
  clock.sleep_for_s(30.0);
}

}  // namespace

TEST_CASE(
    "An ideal VirtualArm stands where forward kinematics says, for every coupling and sense") {
  const Eigen::Vector3d theta(0.4, 1.7, -0.9);
  for (const double sense : {1.0, -1.0})
    for (const bool two_rides : {true, false})
      for (const bool three_rides : {true, false}) {
        VirtualHardware hardware = test::sample_hardware();
        hardware.sense = sense;
        hardware.relative = {two_rides, three_rides};
        VirtualClock clock;
        VirtualArm arm(ideal_truth(), hardware, clock);
        drive_to(arm, hardware, theta, clock);
        const TipPose tip = arm.tip();
        CHECK(std::abs(tip.p.x() - 0.3 * (std::cos(0.4) + std::cos(1.7))) <
              kReachM * kHalfPulseRad);
        CHECK(std::abs(tip.p.y() - sense * 0.3 * (std::sin(0.4) + std::sin(1.7))) <
              kReachM * kHalfPulseRad);
        CHECK(std::abs(wrap_angle(tip.phi + sense * 0.9)) < 3.0 * kHalfPulseRad);
      }
}

TEST_CASE("VirtualArm powers up with its joints at home") {
  VirtualHardware hardware = test::sample_hardware();
  VirtualClock clock;
  VirtualArm arm(ideal_truth(), hardware, clock);
  const Eigen::Vector3d& home = hardware.home_rad;
  CHECK(std::abs(arm.tip().p.x() - 0.3 * (std::cos(home[0]) + std::cos(home[1]))) <
        kReachM * kHalfPulseRad);
  CHECK(arm.drive(1).status().position_pulses ==
        std::lround(hardware.pulses_per_rad()[1] * (home[1] - home[0])));
}

TEST_CASE("A zero offset of a motor that the others ride on turns them all") {
  Truth truth = ideal_truth();
  truth.arm.reducers[0].zero_offset_rad = 0.01;
  VirtualHardware hardware = test::sample_hardware();
  VirtualClock clock;
  VirtualArm straight(ideal_truth(), hardware, clock);
  VirtualArm turned(truth, hardware, clock);
  const Eigen::Vector2d expected = rotation2d(0.01) * straight.tip().p;
  CHECK((turned.tip().p - expected).norm() < 1e-12);
  CHECK(turned.tip().phi - straight.tip().phi == Approx(0.01));
}

TEST_CASE("The tool sags with the square of its reach") {
  Truth truth = ideal_truth();
  truth.arm.sag_m_per_m2 = 0.0015;
  VirtualHardware hardware = test::sample_hardware();
  VirtualClock clock;
  VirtualArm arm(truth, hardware, clock);
  const Eigen::Vector3d p = arm.X_BT().translation();
  CHECK(p.z() == Approx(0.005 - 0.0015 * p.head<2>().squaredNorm()));
}

TEST_CASE("The tip's direction runs from lamp 1 to lamp 2") {
  Truth truth = ideal_truth();
  truth.tool.lamps_m = {Eigen::Vector2d(-0.02, -0.001), Eigen::Vector2d(0.02, 0.001)};
  VirtualHardware hardware = test::sample_hardware();
  VirtualClock clock;
  VirtualArm arm(truth, hardware, clock);
  const Pose X_BT = arm.X_BT();
  const Eigen::Vector3d lamps = X_BT.linear() * Eigen::Vector3d(0.04, 0.002, 0.0);
  CHECK(arm.tip().phi == Approx(std::atan2(lamps.y(), lamps.x())));
}

TEST_CASE("VirtualArm has three drives") {
  VirtualHardware hardware = test::sample_hardware();
  VirtualClock clock;
  VirtualArm arm(ideal_truth(), hardware, clock);
  CHECK_THROWS_AS(arm.drive(3), std::out_of_range);
  CHECK_THROWS_AS(arm.drive(-1), std::out_of_range);
}

}  // namespace planar
