#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "planar_servo/files/cell_file.h"
#include "planar_servo/files/tables/plan_table.h"
#include "planar_servo/offline/record/recorder.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-record", "Drives a cell through a plan and records frames and tracker readings.",
    "planar-record --cell cell.yaml --plan plan.csv --out RECORDING",
    "  254 positions recorded (0 were there before): 732 frames, 17 of them full, in RECORDING"};

struct Options {
  std::filesystem::path cell, plan, recording;
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("--cell", options.cell, "the cell")->required()->type_name("FILE");
  app.add_option("--plan", options.plan, "positions and board views to record")
      ->required()
      ->type_name("FILE");
  app.add_option("--out", options.recording,
                 "folder of the recording; one that holds a part is gone on with")
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
    spdlog::warn("{}: no pair of lamps was seen; its frames are kept", id);
  fmt::print("{} positions recorded ({} were there before): {} frames, {} of them full, in {}\n",
             report.recorded, report.present, report.frames, report.full_frames,
             options.recording.string());
  const FrameCounts seen = devices->camera().counts();
  fmt::print("camera: {}\n", describe(seen));
  return {{{"recorded", report.recorded},
           {"present", report.present},
           {"frames", report.frames},
           {"full_frames", report.full_frames},
           {"frames_incomplete", seen.incomplete},
           {"frames_frozen", seen.frozen},
           {"camera_reopened", seen.reopened},
           {"without_lamps", report.without_lamps}}};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::run);
}
