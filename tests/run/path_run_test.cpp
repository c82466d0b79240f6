#include "planar_servo/work/run/path_run.h"

#include <catch2/catch.hpp>

#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/machine/device_kinds.h"
#include "run/hiccup_cell.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

/// Returns the direction into which the end point goes when every motor turns up a little.
Eigen::Vector2d upwards(const CellSettings& cell, const TipPose& from) {
  const JointPlanner planner = joint_planner(cell);
  const Joints theta = planner.plan(from, cell.arm.home).theta;
  const Transmission& transmission = planner.transmission();
  const Eigen::Vector3d up = Eigen::Vector3d::Constant(1e-4);
  const Joints above = transmission.joints_from_motors(transmission.motors_from_joints(theta) + up);
  return (planner.arm().forward(above).p - planner.arm().forward(theta).p).normalized();
}

/// A calibrated cell whose camera has hiccups, and a run on it that does not check its health.
struct PathBench {
  PathBench() {
    request.cell = std::make_shared<CalibratedCell>(read_calibrated_cell(cell));
    request.folder.path = folder / "run";
    request.policy.checks_health = false;
  }
  /// Returns a line along x at 20 mm/s, by vision.
  PathRequest line(double from_m, double to_m) const {
    const auto at = [&](double x) { return TipPose{{x, 0.20}, cell.tool_orientation}; };
    return {"path.csv", Path({{at(from_m)}, {at(to_m)}}), {Guidance::kVision}, {0.02}};
  }

  test::TemporaryFolder folder;
  CellSettings cell = read_cell(test::workshop_cell_file());
  test::HiccupCell devices{cell};
  ServoRequest request;
};

TEST_CASE("A path does not begin beside its beginning when the look for play breaks off") {
  PathBench bench;
  test::HiccupCell& devices = bench.devices;
  const TipPose start{{0.26, 0.20}, bench.cell.tool_orientation};
  // The camera fails for a second when the arm, which was seen at the beginning, goes above it.
  const Eigen::Vector2d up = upwards(bench.cell, start);
  bool seen = false;
  std::optional<double> failed_s;
  devices.hiccup.at_frame = [&] { seen = seen || (devices.tip() - start.p).norm() < 2e-3; };
  devices.hiccup.fails = [&] {
    const double now_s = devices.clock().now_s();
    if (seen && !failed_s && up.dot(devices.tip() - start.p) > 1e-3) failed_s = now_s;
    return failed_s && now_s < *failed_s + 1.0;
  };
  const PathRequest path = bench.line(0.26, 0.25);
  PathRun run(bench.request, path, devices);
  const PathSpeedResult broken_off = run.follow(0.02, Guidance::kVision);
  REQUIRE(failed_s);
  CHECK(broken_off.status == ServoStatus::kLostCamera);
  CHECK(broken_off.reason == "on the way to the path's beginning: the camera has a hiccup");
  CHECK(run.looks().empty());
  CHECK_FALSE(run.ended_by());
  // The next one finds the play and follows.
  devices.clock().sleep_for_s(1.0);
  CHECK(run.follow(0.02, Guidance::kVision).status == ServoStatus::kReached);
  CHECK(run.looks().size() > 5);
}

TEST_CASE("Where a path ends by an error the arm slows down and keeps its position") {
  PathBench bench;
  test::HiccupCell& devices = bench.devices;
  const PathRequest path = bench.line(0.26, 0.20);
  PathRun run(bench.request, path, devices);
  devices.hiccup.at_frame = [&] {
    if (run.looks().size() > 5) throw WorkError("the disk is full", Cause::kSystem);
  };
  CHECK_THROWS_MATCHES(run.follow(0.02, Guidance::kVision), WorkError,
                       Refused(Cause::kSystem, "disk"));
  for (const DriveStatus& drive : devices.drives().status()) {
    CHECK_FALSE(drive.moving);
    CHECK(drive.position_certain);
  }
}

}  // namespace
}  // namespace planar
