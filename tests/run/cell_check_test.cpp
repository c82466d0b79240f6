#include "planar_servo/work/run/cell_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"

namespace planar {
namespace {

/// What the arm of the sample cell is off from its commands, at most.
constexpr double kArmOff_m = 2e-3;

CalibratedCell by_links(CalibratedCell cell) {
  cell.planner = joint_planner(cell.settings);
  return cell;
}

/// A sound virtual cell, calibrated, whose end point is watched on its way.
struct CheckedCell {
  CheckedCell() {
    robot.energize();
    robot.stop_when([this] {
      way.push_back(*devices->truth()->judge("", {}).p);
      stops.push_back(robot.commanded_joints());
      return false;
    });
  }

  Joints joints(double motor1_deg, double motor2_deg) const {
    return transmission.joints_from_motors({motor1_deg * kDegree, motor2_deg * kDegree, 0.0});
  }
  Eigen::Vector2d place(const Joints& theta) const { return robot.arm().forward(theta).p; }

  /// Keeps the tool's place with the motors at these angles for a later visit.
  void keep(const std::string& id, double motor1_deg, double motor2_deg) {
    const Joints theta = joints(motor1_deg, motor2_deg);
    REQUIRE_FALSE(arrive(robot, joint_planner(cell), cell.servo, theta, {}));
    devices->clock().sleep_for_s(cell.servo.settle_s);
    const TipMeasurement seen = sensor.measure(robot.arm().forward(theta), 3);
    REQUIRE(seen.ok());
    record.places.push_back({id, robot.commanded_joints(), seen.lamps_B, 1e-6});
  }

  /// From now on the end point must not enter a disc about this place.
  void keep_out(const Eigen::Vector2d& p, double radius_m) {
    cell.workspace.keep_out = {{p, radius_m}};
    way.clear();
    stops.clear();
  }
  double nearest_to_disc_m() const {
    double nearest_m = 1.0;
    for (const Eigen::Vector2d& p : way)
      nearest_m = std::min(nearest_m, (p - cell.workspace.keep_out[0].p_B).norm());
    return nearest_m;
  }

  CellCheck check() { return {known, robot, sensor, devices->clock()}; }

  CalibratedCell known{by_links(read_calibrated_cell(read_cell(test::workshop_cell_file())))};
  CellSettings& cell{known.settings};
  std::unique_ptr<CellDevices> devices{open_cell(cell)};
  LampTipSensor sensor{*known.vision, CenterMethod::kAuto, devices->camera(),
                       cell.camera.follow_region_px};
  Transmission transmission{cell.transmission};
  PlanarRobot robot{PlanarArm(cell.arm.geometry), transmission, devices->drives(),
                    devices->clock()};
  HealthRecord record;
  std::vector<Eigen::Vector2d> way;  ///< of the end point in truth
  std::vector<Joints> stops;
};

TEST_CASE("The first moves of a sound cell go the other way where a disc lies in their way") {
  CheckedCell sound;
  const Eigen::Vector3d home =
      sound.transmission.motors_from_joints(sound.robot.commanded_joints());
  sound.keep_out(sound.place(sound.joints(home[0] / kDegree + 20.0, home[1] / kDegree)), 0.02);
  CHECK(findings_text(sound.check().first_moves()).empty());
  CHECK(sound.nearest_to_disc_m() > 0.02 - kArmOff_m);
  CHECK(sound.way.size() > 100);
}

TEST_CASE("A check takes about as long as it is expected to") {
  CheckedCell sound;
  for (const double angle_deg : {0.0, 40.0, 80.0, 120.0})
    sound.keep(fmt::format("place {}", angle_deg), angle_deg, 60.0);
  CellCheck check = sound.check();
  const double begun_s = sound.devices->clock().now_s();
  CHECK(check_cell(check, sound.record).empty());
  const double took_s = sound.devices->clock().now_s() - begun_s;
  CHECK(took_s == Approx(check.expected_s(4, sound.record.places)).epsilon(0.4));
}

TEST_CASE("Play is looked for where the arm stands once two places were visited again") {
  CheckedCell sound;
  sound.keep("first", 0.0, 60.0);
  sound.keep("strayed", 50.0, 60.0);
  sound.keep("corner", 100.0, 60.0);
  sound.keep("last", 100.0, 120.0);
  for (Eigen::Vector2d& lamp_B : sound.record.places[1].lamps_B) lamp_B.x() += 2e-3;
  for (Eigen::Vector2d& lamp_B : sound.record.places[0].lamps_B) lamp_B.x() += 6e-6;
  REQUIRE_FALSE(arrive(sound.robot, joint_planner(sound.cell), sound.cell.servo,
                       sound.joints(0.0, 60.0), {}));
  // Motor 2 has arrived long before motor 1, so this lies on the way from first to last alone.
  sound.keep_out(sound.place(sound.joints(65.0, 120.0)), 0.03);
  CHECK(findings_text(sound.check().revisit(sound.record)).empty());
  CHECK(sound.nearest_to_disc_m() > 0.03 - kArmOff_m);
  const Joints above = sound.joints(0.2, 60.2);
  CHECK(std::any_of(sound.stops.begin(), sound.stops.end(),
                    [&](const Joints& stop) { return (stop - above).head<2>().norm() < 1e-4; }));
}

TEST_CASE("Play is not looked for where a disc lies between the place and that above it") {
  for (const bool hindered : {false, true}) {
    CheckedCell sound;
    sound.keep("only", 20.0, 70.0);
    const Eigen::Vector2d between = sound.place(sound.joints(20.1, 70.1));
    sound.keep_out(hindered ? between : Eigen::Vector2d(0.0, -0.3), 0.4e-3);
    CHECK(findings_text(sound.check().revisit(sound.record)).empty());
    const double above_deg = sound.joints(20.2, 0.0)[0];
    const bool looked =
        std::any_of(sound.stops.begin(), sound.stops.end(),
                    [&](const Joints& stop) { return std::abs(stop[0] - above_deg) < 1e-4; });
    CHECK(looked != hindered);
  }
}

TEST_CASE("A place that was barred since the calibration is left out of the check, or all are") {
  CheckedCell sound;
  for (const double angle_deg : {0.0, 40.0, 80.0})
    sound.keep(fmt::format("place {}", angle_deg), angle_deg, 60.0);
  const auto visits = [&] {
    return CheckWays(sound.cell, [](const TipPose&) { return true; })
        .visits(sound.robot.commanded_joints(), sound.record.places);
  };
  CHECK(visits().order == std::vector<std::size_t>{2, 1, 0});
  sound.keep_out(sound.place(sound.record.places[1].theta), 0.01);
  // Behind the disc the place at 0 degrees is no longer to be reached straight either.
  const VisitPlan plan = visits();
  CHECK(plan.order.front() == 2);
  REQUIRE_FALSE(plan.barred.empty());
  CHECK(findings_text(sound.check().revisit(sound.record)).empty());
  CHECK(sound.nearest_to_disc_m() > 0.01 - kArmOff_m);
  CHECK(sound.way.size() > 10);
  sound.record.places = {sound.record.places[1]};
  const auto found = sound.check().revisit(sound.record);
  REQUIRE(found.size() == 1);
  CHECK(found[0].what == HealthCause::kNotVisited);
  CHECK(found[0].cause == Cause::kUnreachable);
}

}  // namespace
}  // namespace planar
