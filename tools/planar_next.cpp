#include "planar_servo/calibration/board.h"
#include "planar_servo/console/doctor/next_step.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{"planar-next", "planar-next --cell cell.yaml [--grid BOARD]",
                        R"(done  cell file    cell.yaml is in order
next  plan         plan.csv does not exist yet
      planar-plan --cell cell.yaml --readings 200 -o plan.csv
open  recording    recording does not exist yet
open  camera       camera.yaml does not exist yet)"};

struct Options {
  std::filesystem::path cell;
  std::string board{kUsualBoard};
};

void add_options(CLI::App& app, Options& options) {
  add_required(
      app, "--cell", options.cell, "cell.yaml",
      "the cell; beside it lies what the work makes: plan.csv, recording, lamps.csv, pairs.csv, "
      "targets.csv, run, certificate");
  add_default(app, "--grid", options.board, "BOARD", "the calibration board");
}

Outcome work(const Options& options) {
  parse_board(options.board);
  const auto steps = work_steps(options.cell, options.board);
  say("{}", steps_text(steps));
  return {steps_json(steps)};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::work);
}
