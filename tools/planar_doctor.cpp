#include <fmt/format.h>

#include <filesystem>

#include "planar_servo/doctor/doctor.h"
#include "planar_servo/doctor/doctor_report.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{"planar-doctor",
                        "Looks at a cell's file and devices and says what mends each fault.",
                        "planar-doctor --cell cell.yaml",
                        "  well      cell file: cell.yaml is in order\n"
                        "  doubtful  drive 2: Tic 36v4 00422222 at /dev/bus/usb/001/004, firmware "
                        "1.09, supply 24.0 V; it does not know where it stands\n"
                        "            -> home it with planar-jog"};

struct Options {
  std::filesystem::path cell;
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("--cell", options.cell, "the cell")->required()->type_name("FILE");
}

Outcome work(const Options& options) {
  const auto findings = examine_cell(options.cell);
  fmt::print("{}", findings_text(findings));
  return {findings_json(findings), is_sound(findings)};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::work);
}
