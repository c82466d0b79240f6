#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "planar_servo/files/tables/plan_table.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/record/record_report.h"
#include "planar_servo/offline/record/recorder.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-record", "Drives a cell through a plan and records frames and tracker readings.",
    "planar-record --cell cell.yaml --plan plan.csv --out RECORDING",
    "1 positions recorded (0 were there before): 3 frames, 1 of them full, in RECORDING\n"
    "camera: 3 whole frames; left out: 0 with parts missing, 0 repeated; the camera was lost and "
    "found 0 times"};

struct Options {
  std::filesystem::path cell, plan, recording;
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("--cell", options.cell, "the cell")->required()->type_name("FILE");
  app.add_option("--plan", options.plan, "positions and board views to record")
      ->required()
      ->type_name("FILE");
  app.add_option("--out", options.recording,
                 "folder of the recording; a recording that was begun is continued")
      ->required()
      ->type_name("DIR");
}

Outcome run(const Options& options) {
  const CellSettings cell = read_cell(options.cell);
  const RecordRequest request{cell, read_plan(options.plan, cell.tool_orientation),
                              options.recording, interrupted};
  heed_interrupts();
  const auto devices = open_cell(request.cell);
  const RecordReport report = record(request, *devices);
  for (const std::string& id : report.without_lamps)
    spdlog::warn(fmt::format("{}: no pair of lamps was seen; its frames are kept", id));
  const FrameCounts frames = devices->camera().counts();
  fmt::print("{}", record_text(report, frames, options.recording));
  return {record_json(report, frames)};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::run);
}
