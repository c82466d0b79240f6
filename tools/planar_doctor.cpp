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
                        R"(well      cell file: cell.yaml is in order
well      drive 1: Tic 36v4 00411111 at /dev/bus/usb/001/002, firmware 1.09, supply 24.0 V
well      camera: answers at 127.0.0.1 over lo)"};

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
