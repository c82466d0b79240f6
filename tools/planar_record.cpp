#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "app/recorder.h"
#include "files/cell_file.h"
#include "files/tables.h"
#include "program.h"

namespace {

const planar::ProgramText kText{
    "planar-record", "Drives a cell through a plan and records frames and tracker readings.",
    "planar-record --cell cell.yaml --plan plan.csv --out RECORDING",
    "  254 positions recorded (0 were there before): 732 frames, 17 of them full, in RECORDING"};

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path cell_file, plan_file, recording;
  const auto options = [&](CLI::App& app) {
    app.add_option("--cell", cell_file, "the cell")->required()->type_name("FILE");
    app.add_option("--plan", plan_file, "positions and board views to record")
        ->required()
        ->type_name("FILE");
    app.add_option("--out", recording,
                   "folder of the recording; one that holds a part is gone on with")
        ->required()
        ->type_name("DIR");
  };
  return planar::run_program(kText, argc, argv, options, [&] {
    const planar::RecordRequest request{planar::read_cell(cell_file), planar::read_plan(plan_file),
                                        recording};
    const auto devices = planar::open_cell(request.cell);
    const planar::RecordReport report = planar::record(request, *devices);
    for (const std::string& id : report.without_lamps)
      spdlog::warn("{}: no pair of lamps was seen; its frames are kept", id);
    fmt::print("{} positions recorded ({} were there before): {} frames, {} of them full, in {}\n",
               report.recorded, report.present, report.frames, report.full_frames,
               recording.string());
    return planar::Outcome{{{"recorded", report.recorded},
                            {"present", report.present},
                            {"frames", report.frames},
                            {"full_frames", report.full_frames},
                            {"without_lamps", report.without_lamps}}};
  });
}
