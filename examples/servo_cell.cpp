// Positions the arm of a calibrated cell by looking at it: servo_cell CELL.yaml
// The same program serves a virtual and a real cell; the file decides.
#include <planar_servo/files/calibration_files.h>
#include <planar_servo/hardware/robot/planar_robot.h>
#include <planar_servo/loop/servo/position_servo.h>
#include <planar_servo/loop/vision/lamp_tip_sensor.h>
#include <planar_servo/loop/vision/see_tool.h>
#include <planar_servo/machine/device_kinds.h>

#include <cstdio>

namespace {

bool reach_targets(const planar::CellSettings& cell, planar::CellDevices& devices) {
  planar::PlanarRobot robot(planar::PlanarArm(cell.arm.geometry),
                            planar::Transmission(cell.transmission), devices.drives(),
                            devices.clock());
  robot.energize();
  const planar::VisionCalibration vision = planar::read_vision(cell, true);
  planar::LampTipSensor sensor(vision, cell.lamps.method, devices.camera(),
                               cell.camera.follow_region_px);
  const planar::GuardLimits limits =
      planar::guard_limits(vision, cell.workspace, cell.tool_orientation);
  planar::UnknownLandings landings(limits.distance_m);
  planar::PositionServo servo(cell.servo, limits, planar::joint_planner(cell), robot, sensor,
                              devices.clock(), &landings);
  bool all_reached = true;
  for (const Eigen::Vector2d& p :
       {Eigen::Vector2d(0.15, 0.25), Eigen::Vector2d(-0.2, 0.3), Eigen::Vector2d(0.05, -0.35)}) {
    const planar::ServoResult result = servo.move_to({p, cell.tool_orientation});
    std::printf("target (%.0f, %.0f) mm: %s after %d corrections", 1e3 * p.x(), 1e3 * p.y(),
                planar::name(result.status), result.iterations);
    if (!result.steps.empty())
      std::printf(", %.4f mm away by its own view", 1e3 * result.steps.back().error.norm());
    if (const auto truth = devices.truth())  // only a virtual cell knows
      std::printf(", %.4f mm in truth", 1e3 * (*truth->judge("", {}).p - p).norm());
    std::printf("%s\n", result.reason.empty() ? "" : (": " + result.reason).c_str());
    all_reached = all_reached && result.status == planar::ServoStatus::kReached;
  }
  return all_reached;
}

}  // namespace

int main(int argc, char** argv) try {
  const planar::CellSettings cell = planar::read_cell(argc > 1 ? argv[1] : "cell.yaml");
  return reach_targets(cell, *planar::open_cell(cell)) ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
