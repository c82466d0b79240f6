#include "planar_servo/virtual_cell/virtual_arm.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "planar_servo/virtual_cell/virtual_drive.h"
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

TEST_CASE("A tip creeps after a stop, by what its way left behind") {
  Truth truth = ideal_truth();
  truth.arm.creep = CreepTruth{12e-6, 2.0};
  VirtualHardware hardware = test::sample_hardware();
  VirtualClock clock;
  VirtualArm creeps(truth, hardware, clock), ideal(ideal_truth(), hardware, clock);
  const auto behind_m = [&]() -> Eigen::Vector2d { return ideal.tip().p - creeps.tip().p; };
  CHECK(behind_m().norm() == 0.0);
  clock.sleep_for_s(1.0);
  const Eigen::Vector2d from_m = ideal.tip().p;
  const auto turn_both = [&](double turn_rad) {
    for (VirtualArm* arm : {&creeps, &ideal}) {
      arm->drive(0).energize();
      arm->drive(0).set_target(
          arm->drive(0).status().position_pulses +
          static_cast<std::int32_t>(std::lround(hardware.pulses_per_rad()[0] * turn_rad)));
    }
    while (ideal.moves()) clock.sleep_for_s(0.001);
  };
  turn_both(0.8);
  const Eigen::Vector2d way_m = (ideal.tip().p - from_m).normalized();
  CHECK(behind_m().dot(way_m) == Approx(12e-6).epsilon(0.01));
  clock.sleep_for_s(2.0);
  CHECK(behind_m().norm() == Approx(12e-6 * std::exp(-1.0)).epsilon(0.01));
  turn_both(0.001);
  CHECK(behind_m().norm() < 0.1 * 12e-6);
}

TEST_CASE("A beam sags with both links' reach, which no multiple of the squared reach does") {
  Truth truth = ideal_truth();
  truth.arm.beam_sag = BeamSagTruth{0.0015, 0.003};
  VirtualHardware hardware = test::sample_hardware();
  const auto sag_at_bend = [&](double bend) {
    hardware.home_rad << 0.3, 0.3 + bend, 0.0;
    VirtualClock clock;
    return 0.005 - VirtualArm(truth, hardware, clock).X_BT().translation().z();
  };
  constexpr double kPulses = 1e-8;  // metres: the bend is of whole pulses
  CHECK(std::abs(sag_at_bend(0.0) - 0.0015 * 0.09 * 7.0 / 3.0) < kPulses);
  CHECK(std::abs(sag_at_bend(kPi / 2.0) - (0.0015 * 0.03 + 0.003 * 0.09)) < kPulses);
  CHECK(std::abs(sag_at_bend(-kPi / 2.0) - sag_at_bend(kPi / 2.0)) < kPulses);
  // At a bend of 90 degrees the squared reach is half of that of the straight arm.
  CHECK(std::abs(sag_at_bend(kPi / 2.0) - 0.5 * sag_at_bend(0.0)) > 0.1e-3);
}

TEST_CASE("Leaning axes lift the tool and tilt it, each in the direction of its own link") {
  constexpr double kLean = 0.001;  // rad
  constexpr double kSecondOrder = kLean * kLean;
  const VirtualHardware hardware = test::sample_hardware();
  const Eigen::Vector3d& home = hardware.home_rad;
  const auto leaning = [&](std::size_t joint) {
    Truth truth = ideal_truth();
    const Eigen::Vector2d none(0.0, 0.0);
    truth.arm.axis_leans_rad = {none, none, none};
    (*truth.arm.axis_leans_rad)[joint] = {kLean, 0.0};
    VirtualClock clock;
    return VirtualArm(truth, hardware, clock).X_BT();
  };
  const double z1 = 0.3 * (std::sin(home[0]) + std::sin(home[1])) * kLean;
  CHECK(std::abs(leaning(0).translation().z() - 0.005 - z1) < kSecondOrder);
  CHECK(std::abs(leaning(0).linear()(1, 2) + kLean) < kSecondOrder);
  const double z2 = 0.3 * std::sin(home[1] - home[0]) * kLean;
  CHECK(std::abs(leaning(1).translation().z() - 0.005 - z2) < kSecondOrder);
  CHECK(std::abs(leaning(1).linear()(1, 2) + std::cos(home[0]) * kLean) < kSecondOrder);
  CHECK(std::abs(leaning(2).translation().z() - 0.005) < kSecondOrder);
  CHECK(std::abs(leaning(2).linear()(1, 2) + std::cos(home[1]) * kLean) < kSecondOrder);
}

TEST_CASE("An arm whose axes lean by nothing stands to the bit where one without leans stands") {
  Truth truth = draw_truth(1);
  const VirtualHardware hardware = test::sample_hardware();
  VirtualClock clock;
  const Pose plain = VirtualArm(truth, hardware, clock).X_BT();
  const Eigen::Vector2d none(0.0, 0.0);
  truth.arm.axis_leans_rad = {none, none, none};
  truth.outliers = OutlierTruth{0.0, 0.001, 0.001};
  CHECK(VirtualArm(truth, hardware, clock).X_BT().matrix() == plain.matrix());
}

TEST_CASE("An arm misses at few stops, and by as much as long as it stays near") {
  Truth truth = ideal_truth();
  truth.outliers = OutlierTruth{0.02, 0.0002, 0.003};
  const VirtualHardware hardware = test::sample_hardware();
  VirtualClock clock;
  VirtualArm arm(truth, hardware, clock), true_arm(ideal_truth(), hardware, clock);
  constexpr int kPlaces = 5000;
  const auto missed_by = [&](std::int32_t pulses) {
    arm.drive(0).turn_shaft(pulses);
    true_arm.drive(0).turn_shaft(pulses);
    return (arm.tip().p - true_arm.tip().p).norm();
  };
  std::vector<double> lengths;
  std::int32_t a_missed_place = 0;
  const std::int32_t far = 3000;  // pulses, more than a degree
  for (std::int32_t place = 0; place < kPlaces * far; place += far)
    if (const double length = missed_by(place); length > 0.0) {
      lengths.push_back(length);
      a_missed_place = place;
    }
  const double expected = 0.02 * kPlaces;
  CHECK(std::abs(static_cast<double>(lengths.size()) - expected) < 5.0 * std::sqrt(expected));
  const auto [least, greatest] = std::minmax_element(lengths.begin(), lengths.end());
  CHECK(*least > 0.0002 * 0.999);
  CHECK(*greatest < 0.003 * 1.001);
  CHECK(*greatest > 5.0 * *least);
  // Come there again, it stops anew; a correction leaves it as far off as it was.
  CHECK(missed_by(a_missed_place) == 0.0);
  truth.outliers->share = 1.0;
  VirtualArm straying(truth, hardware, clock);
  const auto strays_by = [&](std::int32_t pulses) {
    straying.drive(0).turn_shaft(pulses);
    true_arm.drive(0).turn_shaft(pulses);
    return (straying.tip().p - true_arm.tip().p).norm();
  };
  const double first = strays_by(far), elsewhere = strays_by(2 * far), again = strays_by(far);
  CHECK(elsewhere != Approx(first).epsilon(1e-9));
  CHECK(again != Approx(first).epsilon(1e-9));
  CHECK(strays_by(far + 100) == Approx(again).epsilon(1e-9));
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
