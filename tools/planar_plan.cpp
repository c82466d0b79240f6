#include <spdlog/spdlog.h>

#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/plan/proposed_plan.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{"planar-plan",
                        "planar-plan --cell cell.yaml --readings N [--unattended M] [--lays L]\n"
                        "                   [--after pairs.csv [--accept-stale]] -o plan.csv",
                        R"(rows                40
end point           0.0095 mm expected now, 0.0042 mm after these readings
nearly there        after 37 places for training)"};

struct Options {
  std::filesystem::path cell, after, output;
  PlanRequest plan;
  bool accept_stale{false};
};

Outcome propose(const Options& options) {
  if (!options.after.empty()) require_not_input(options.output, options.after);
  require_writable(options.output, "plan");
  const CellSettings cell = read_cell(options.cell);
  if (options.plan.readings > 0 && !cell.tracker.kind->measures())
    spdlog::warn("{}: names no tracker, without which planar-record refuses this plan; name it",
                 options.cell.string());
  std::vector<PairRow> pairs;
  if (!options.after.empty()) {
    accept_stale(
        contradictions({{Role::kPairs, options.after}},
                       origins_in(cell, calibration_files(cell, false)), values_of(kRoles)),
        options.accept_stale);
    pairs = read_pairs(options.after);
  }
  const ProposedPlan plan = propose_plan(cell, options.plan, pairs);
  write_file(options.output, plan_text(plan.rows));
  return told(proposal_list(plan));
}

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  add_required(app, "--readings", options.plan.readings, "N",
               "tracker readings to plan; the sweeps of a first plan take a quarter of them; 0 for "
               "a cell without a tracker")
      ->check(CLI::Range(0, 10000));
  add_value(app, "--unattended", options.plan.unattended, "M",
            "places that only the camera watches, with the tool turned anyhow")
      ->check(CLI::Range(0, 10000));
  CLI::Option* lays = add_default(app, "--lays", options.plan.lays, "L",
                                  "times that the board is laid on the plane, turned and shifted")
                          ->check(CLI::Range(1, 1000));
  add_value(app, "--after", options.after, "pairs.csv",
            "pairs of the readings so far; without them the plan begins a calibration")
      ->excludes(lays);
  app.add_flag("--accept-stale", options.accept_stale,
               "plan even after pairs that were not made with the cell's files")
      ->needs("--after");
  add_required(app, "-o,--out", options.output, "plan.csv", "the plan to write");
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::propose);
}
