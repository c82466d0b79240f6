#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/learn/field/arm/arm_fit.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/calibrate_arm.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-calibrate-arm",
    "planar-calibrate-arm --cell cell.yaml [--report FILE.html|none] -o arm.yaml "
    "pairs.csv | samples.csv",
    R"(readings met        0.0172 mm rms, 2 harmonics of each reducer
places left out     0.0192 mm rms

The arm, as found from the poses
  term                       value  by the readings
  link 1  299.87668 +- 0.00197 mm
  link 2  300.17470 +- 0.00319 mm)"};

struct Options {
  std::filesystem::path cell, output, table;
  std::string report;
};

Outcome calibrate(const Options& options) {
  require_not_input(options.output, options.table);
  require_writable(options.output, "arm");
  const auto page = page_for(options.report, options.output);
  const CellSettings cell = read_cell(options.cell);
  const ArmFit fit = fit_arm(arm_of_files(cell), read_arm_readings(cell, options.table));
  const std::vector<Origin> origins{origin_of({Role::kPairs, options.table}), arm_origin(cell)};
  write_file(options.output,
             found_arm_text(fit.estimate.arm(), arm_terms(fit.estimate), origins, kText.name));
  Outcome outcome = told(arm_list(fit));
  if (page) write_page(*page, arm_page(fit, options.output));
  return outcome;
}

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  add_required(app, "-o,--out", options.output, "arm.yaml", "the arm to write");
  add_report_option(app, options.report);
  add_required(app, "table", options.table, "pairs.csv|samples.csv",
               "pairs.csv of planar-pair-tracker, or a table id,theta1_deg,theta2_deg,"
               "theta3_deg,x_mm,y_mm,sigma_mm");
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::calibrate);
}
