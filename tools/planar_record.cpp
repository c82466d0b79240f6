#include "homing_options.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/work_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/record/recorder.h"
#include "planar_servo/work/workpiece/bar_places.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-record",
    "planar-record --cell cell.yaml --plan plan.csv --out RECORDING [--home] [--at-marks]\n"
    "                     [--nearest-turn] [--grid circles:COLSxROWS:PITCHmm]\n"
    "                     [--display auto|none] [--on-bad-reading repeat|skip|stop]\n"
    "       planar-record --cell cell.yaml --bar bar.csv [--bar-places N] --out DIR",
    "1 positions recorded (0 were there before): 3 frames, 1 of them full\n"
    "recording: RECORDING\n"
    "camera: 3 whole frames; left out: 0 with parts missing, 0 repeated; the camera was lost and "
    "found 0 times"};

struct Options {
  std::filesystem::path cell, plan, bar;
  std::size_t bar_places{kBarPlaces};
  RecordRequest request;
  std::string grid;  ///< empty: none
  HomingOptions homing;
};

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  CLI::Option* plan =
      add_value(app, "--plan", options.plan, "plan.csv", "positions and board views to record");
  add_required(app, "--out", options.request.recording, "DIR",
               "folder of the recording; a recording that was begun is continued");
  add_homing_options(app, options.homing);
  CLI::Option* grid = add_value(
      app, "--grid", options.grid, "BOARD",
      "the board that a person shows to a real cell's camera: circles or chessboard, such "
      "as circles:11x11:50mm; ? for a pitch that is not known");
  CLI::Option* display = add_choice(
      app, "--display", options.request.display, kDisplayPolicies,
      "auto: draw a map of what is done and left, and what the camera sees of the board, into "
      "RECORDING/view.png; none");
  CLI::Option* bar =
      add_value(app, "--bar", options.bar, "bar.csv",
                "take pictures of a bar of certified length instead, place by place, into "
                "DIR/bar_NN.png; nothing moves");
  bar->excludes(plan)->excludes(grid)->excludes(display);
  add_default(app, "--bar-places", options.bar_places, "N", "how many places of the bar")
      ->needs(bar)
      ->check(CLI::Range(1, 99));
  add_choice(app, "--on-bad-reading", options.request.on_bad_reading, kBadReadings,
             "what happens to a place without a good tracker reading: it is taken "
             "again up to twice, left out, or the recording stops");
}

Outcome take_bar(const Options& options) {
  const CellSettings settings = read_cell(options.cell);
  require_devices(settings);
  const std::vector<Fiducial> bar = read_bar(options.bar);
  const VisionCalibration vision = read_vision(settings, false);
  make_folder(options.request.recording);
  heed_interrupts();
  const auto devices = open_cell(settings);
  Terminal terminal;
  const auto pictures =
      record_bar(bar, vision, settings.workspace, options.bar_places, options.request.recording,
                 devices->camera(), terminal, interrupted);
  ReportList list;
  list.line("", "{pictures} pictures of the bar in " + options.request.recording.string(),
            pictures.size());
  return told(list);
}

Outcome run(const Options& options) {
  if (!options.bar.empty()) return take_bar(options);
  if (options.plan.empty())
    throw InputError(Refusal{"--plan or --bar is needed", "name what is to be recorded"});
  RecordRequest request = options.request;
  request.cell = read_cell(options.cell);
  request.plan = read_plan(options.plan, request.cell.tool_orientation);
  request.stop = interrupted;
  if (!options.grid.empty()) request.board = parse_board(options.grid, BoardUse::kShape);
  request.may_home = may_home(options.homing);
  heed_interrupts();
  const auto devices = open_cell(request.cell);
  const RecordReport report = record(request, *devices);
  return told(record_list(report, devices->camera().counts(), request.recording));
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::run);
}
