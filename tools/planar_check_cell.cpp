
#include <nlohmann/json.hpp>

#include "homing_options.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/files/vision_files.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/run/cell_check.h"
#include "planar_servo/servo/approach.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-check-cell", "planar-check-cell --cell cell.yaml [--home] [--at-marks]",
    R"(the camera has shifted by 0.998 mm; what still holds: camera.yaml and tool.yaml; what to do: put the camera back, or record the places again and run planar-pair-tracker and planar-fit-error-map)"};

struct Options {
  std::filesystem::path cell;
  HomingOptions homing;
};

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  add_homing_options(app, options.homing);
}

Outcome check(const Options& options) {
  const CellSettings cell = read_cell(options.cell);
  const bool with_map = std::filesystem::exists(cell.error_map);
  const VisionCalibration vision = read_vision(cell, with_map);
  require_belonging(stale_files(cell, with_map));
  const auto health = read_cell_health(cell);
  if (!health)
    throw InputError({"names no health file that exists, so there is nothing to compare with",
                      "make one with planar-pair-tracker --health-out and name it under `health`",
                      cell.file});
  heed_interrupts();
  const auto devices = open_cell(cell);
  PlanarRobot robot(PlanarArm(cell.arm.geometry), Transmission(cell.transmission),
                    devices->drives(), devices->clock());
  robot.stop_when(interrupted);
  robot.energize();
  home_where_needed(robot, may_home(options.homing));
  LampTipSensor sensor(vision, cell.lamps.method, devices->camera(), cell.camera.follow_region_px);
  CellCheck procedure(cell, vision, robot, sensor, devices->clock(),
                      servo_planner(cell).scatter_m(), [&](const std::string& reason) {
                        return wait_for_camera(devices->camera(), robot, devices->clock(),
                                               "the check", reason,
                                               devices->clock().now_s() + kCameraPatience_s);
                      });
  const std::vector<HealthFinding> found = check_cell(procedure, health);
  say("{}", found.empty() ? "the cell is as it was at its calibration\n" : findings_text(found));
  return {findings_json(found), found.empty()};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::check);
}
