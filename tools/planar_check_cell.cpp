#include "homing_options.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/run/cell_check.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-check-cell",
    "planar-check-cell --cell cell.yaml [--home] [--at-marks] [--nearest-turn]",
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
  const CellSettings settings = read_cell(options.cell);
  const CalibratedCell cell = read_checkable_cell(settings);
  heed_interrupts();
  const auto devices = open_cell(settings);
  const std::vector<HealthFinding> found =
      check_devices(cell, *devices, may_home(options.homing), interrupted);
  say("{}", found.empty() ? "the cell is as it was at its calibration\n" : findings_text(found));
  return {findings_json(found), found.empty()};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::check);
}
