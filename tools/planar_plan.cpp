

#include "planar_servo/core/units.h"
#include "planar_servo/files/cell_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/plan/proposed_plan.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-plan",
    "planar-plan --cell cell.yaml --readings N [--after pairs.csv [--accept-stale]] -o plan.csv",
    R"(rows                40
end point           0.0095 mm expected now, 0.0042 mm after these readings
nearly there        after 37 places for training)"};

struct Options {
  std::filesystem::path cell, after, output;
  int readings{0};
  bool accept_stale{false};
};

/// Reads the pairs. Throws InputError for those of another cell or calibration, unless that is
/// accepted.
std::vector<PairRow> pairs_of_cell(const Options& options, const CellSettings& cell) {
  accept_stale(contradictions({{Role::kPairs, options.after}},
                              origins_in(cell, calibration_files(cell, false)), values_of(kRoles)),
               options.accept_stale);
  return read_pairs(options.after);
}

Outcome propose(const Options& options) {
  if (!options.after.empty()) require_not_input(options.output, options.after);
  require_writable(options.output, "plan");
  const CellSettings cell = read_cell(options.cell);
  std::vector<PairRow> pairs;
  if (!options.after.empty()) pairs = pairs_of_cell(options, cell);
  const ProposedPlan plan = propose_plan(cell, options.readings, pairs);
  write_file(options.output, plan_text(plan.rows));
  say("{}", proposal_text(plan));
  return {{{"rows", plan.rows.size()},
           {"expected_before_mm", mm(plan.before)},
           {"expected_after_mm", mm(plan.after)},
           {"enough", plan.enough},
           {"worth_reading", plan.worth_reading()}}};
}

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  add_required(app, "--readings", options.readings, "N",
               "tracker readings to plan; the sweeps of a first plan take a quarter of them")
      ->check(CLI::Range(1, 10000));
  add_value(app, "--after", options.after, "pairs.csv",
            "pairs of the readings so far; without them the plan "
            "begins a calibration");
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
