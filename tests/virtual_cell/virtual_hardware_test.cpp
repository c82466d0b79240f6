#include "planar_servo/virtual_cell/virtual_drive.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/virtual_cell/virtual_cell.h"
#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

constexpr double kPulses_rad = 4.0 * 2.0 * kPi / 5e5;  // roundings of all motors together

/// A cell without any error of its arm, built as `build` says and with its joints at home in
/// sample_hardware().
VirtualCell ideal_cell(const BuildTruth& build) {
  Truth truth;
  truth.tool.lamps_m = {Eigen::Vector2d(-0.02, 0.0), Eigen::Vector2d(0.02, 0.0)};
  truth.build = build;
  return {truth, test::sample_hardware()};
}

/// Sends the motors on by these angles, as whoever trusts sample_hardware() computes their pulses.
TipPose turned(VirtualCell& cell, const Eigen::Vector3d& motors_rad) {
  const Eigen::Vector3d pulses_per_rad = test::sample_hardware().pulses_per_rad();
  for (int joint = 0; joint < 3; ++joint) {
    cell.drive(joint).energize();
    cell.drive(joint).set_target(
        cell.drive(joint).status().position_pulses +
        static_cast<std::int32_t>(std::lround(pulses_per_rad[joint] * motors_rad[joint])));
  }
  cell.clock().sleep_for_s(30.0);
  return cell.true_tip();
}

/// Where an ideal arm stands with its joints at `theta`.
TipPose ideal_tip(const Eigen::Vector3d& theta, double sense = 1.0) {
  const Eigen::Vector2d p = 0.3 * (rotation2d(theta[0]).col(0) + rotation2d(theta[1]).col(0));
  return {{p.x(), sense * p.y()}, sense * theta[2]};
}

void check_tip(const TipPose& tip, const TipPose& expected) {
  CHECK((tip.p - expected.p).norm() < kPulses_rad);
  CHECK(std::abs(wrap_angle(tip.phi - expected.phi)) < kPulses_rad);
}

const Eigen::Vector3d kTurn(0.2, -0.4, 0.5);  // of the motors
/// The joints after kTurn in a cell that is as stated, in which motors 2 and 3 ride.
const Eigen::Vector3d kTheta =
    test::sample_hardware().home_rad + Eigen::Vector3d(0.2, 0.2 - 0.4, 0.2 - 0.4 + 0.5);

}  // namespace

TEST_CASE("A build that states nothing, or what the cell states, is the cell as stated") {
  VirtualCell silent = ideal_cell({}),
              stated = ideal_cell(build_as_stated(test::sample_hardware()));
  const TipPose tip = turned(silent, kTurn), same = turned(stated, kTurn);
  check_tip(tip, ideal_tip(kTheta));
  CHECK(tip.p == same.p);
  CHECK(tip.phi == same.phi);
}

TEST_CASE("A true gear of 1.005 turns the joint by that much less than its pulses say") {
  BuildTruth build;
  build.gear_ratios = Eigen::Vector3d(100.5, 100.0, 50.0);
  VirtualCell cell = ideal_cell(build);
  const Eigen::Vector3d all = Eigen::Vector3d::Constant(0.2 / 1.005 - 0.2);
  check_tip(turned(cell, kTurn), ideal_tip(kTheta + all));
}

TEST_CASE("A truly reversed joint turns the other way, from the same home") {
  BuildTruth build;
  build.directions = Eigen::Vector3d(1.0, -1.0, -1.0);  // joint 3 is stated as +1
  VirtualCell cell = ideal_cell(build);
  check_tip(cell.true_tip(), ideal_tip(test::sample_hardware().home_rad));
  check_tip(turned(cell, kTurn), ideal_tip(kTheta - Eigen::Vector3d(0.0, 0.0, 2.0 * 0.5)));
}

TEST_CASE("A truly absolute motor leaves its joint where the link before it turns") {
  BuildTruth build;
  build.relative = {true, false};
  VirtualCell cell = ideal_cell(build);
  check_tip(turned(cell, kTurn), ideal_tip({kTheta[0], kTheta[1], 0.0 + 0.5}));
}

TEST_CASE("A true sense of rotation mirrors the arm") {
  BuildTruth build;
  build.sense = -1.0;
  VirtualCell cell = ideal_cell(build);
  check_tip(turned(cell, kTurn), ideal_tip(kTheta, -1.0));
}

TEST_CASE("At its true home the drives count what the cell states for home, after homing too") {
  BuildTruth build;
  build.home_rad = test::sample_hardware().home_rad + Eigen::Vector3d(0.1, 0.1, 0.1);
  VirtualCell cell = ideal_cell(build);
  const Eigen::Vector3i counted = test::sample_hardware().home_pulses();
  for (int joint = 0; joint < 3; ++joint)
    CHECK(cell.drive(joint).status().position_pulses == counted[joint]);
  check_tip(turned(cell, kTurn), ideal_tip(kTheta + Eigen::Vector3d(0.1, 0.1, 0.1)));
  cell.drive(0).start_homing(HomeDirection::kReverse);
  cell.clock().sleep_for_s(30.0);
  CHECK(cell.drive(0).status().position_pulses == 0);
  check_tip(cell.true_tip(), ideal_tip(kTheta + Eigen::Vector3d(-0.1, -0.1, -0.1)));
}

TEST_CASE("Motors that are turned from outside count as the cell states, too") {
  BuildTruth build;
  build.home_rad = test::sample_hardware().home_rad + Eigen::Vector3d(0.1, 0.1, 0.1);
  VirtualCell cell = ideal_cell(build);
  cell.turn_motor(0, test::sample_hardware().home_pulses()[0]);
  check_tip(cell.true_tip(), ideal_tip(*build.home_rad));
}

TEST_CASE("The drives' limits are the stated ones in pulses, whatever the true gear") {
  BuildTruth build;
  build.gear_ratios = Eigen::Vector3d(200.0, 100.0, 50.0);
  VirtualCell slow = ideal_cell(build), stated = ideal_cell({});
  const auto pulses_after_one_second = [](VirtualCell& cell) {
    cell.drive(0).energize();
    cell.drive(0).set_target(1000000);
    cell.clock().sleep_for_s(1.0);
    return cell.drive(0).status().position_pulses;
  };
  CHECK(pulses_after_one_second(slow) == pulses_after_one_second(stated));
}

TEST_CASE("A monument is read where it truly stands, and where it is stated unless it has moved") {
  Truth truth;
  truth.build.monuments_B = {{"datum2", {0.451, 0.45, 0.0}}, {"unknown to the cell", {0, 0, 0.1}}};
  VirtualCell cell(truth, test::sample_hardware());
  const auto read = [&](const char* id) { return cell.tracker().measure_monument(id).reading.p_L; };
  CHECK(read("datum1") == Eigen::Vector3d(-0.45, -0.45, 0.0));
  CHECK(read("datum2") == Eigen::Vector3d(0.451, 0.45, 0.0));
  CHECK(read("unknown to the cell") == Eigen::Vector3d(0.0, 0.0, 0.1));
}

}  // namespace planar
