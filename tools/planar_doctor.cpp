#include <cstdlib>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/console/doctor/doctor.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/run/dry_run.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{"planar-doctor",
                        fmt::format("planar-doctor --cell cell.yaml\n"
                                    "       planar-doctor --new cell.yaml --drives {}\n"
                                    "       planar-doctor --seal map.yaml",
                                    fmt::join(new_cell_drives(), "|")),
                        R"(well      cell file: cell.yaml is in order
well      drive 1: Tic 36v4 00411111 at /dev/bus/usb/001/002, firmware 1.09, supply 24.0 V
well      camera: answers at 127.0.0.1 over lo: Aravis Fake, version 0.8.26)"};

struct Options {
  std::filesystem::path cell;
  std::filesystem::path new_cell;
  std::string drives;
  std::filesystem::path sealed;
};

void add_options(CLI::App& app, Options& options) {
  CLI::Option* cell = add_value(app, "--cell", options.cell, "cell.yaml", "the cell");
  CLI::Option* new_cell = add_value(app, "--new", options.new_cell, "cell.yaml",
                                    "write a commented cell file to fill in")
                              ->excludes(cell);
  CLI::Option* drives =
      app.add_option("--drives", options.drives, "the kind of drives of the new cell")
          ->check(CLI::IsMember(new_cell_drives()))
          ->needs(new_cell);
  new_cell->needs(drives);
  add_value(app, "--seal", options.sealed, "map.yaml",
            "say in a calibration file that it was edited by hand, so that it is read again")
      ->excludes(cell)
      ->excludes(new_cell);
}

Outcome write_new(const Options& options) {
  write_new_cell(options.new_cell, options.drives);
  const std::string file = options.new_cell.string();
  say("wrote {}; replace its values by your own, then planar-doctor --cell {}\n", file, file);
  return {{{"cell", file}, {"drives", options.drives}}};
}

Outcome seal(const std::filesystem::path& file) {
  const bool changed = seal_by_hand(file);
  if (changed)
    say("sealed {}; it says that it was edited by hand\n", file.string());
  else
    say("{} is as it was written; nothing is to be sealed\n", file.string());
  return {{{"file", file.string()}, {"sealed", changed}}};
}

Outcome work(const Options& options) {
  if (!options.new_cell.empty()) return write_new(options);
  if (!options.sealed.empty()) return seal(options.sealed);
  if (options.cell.empty())
    throw InputError(Refusal{"--cell, --new or --seal is required", "--help explains each"});
  auto findings = examine_cell(options.cell);
  if (is_sound(findings)) {
    if (const auto doubt = foresee_check(read_calibrated_cell(read_cell(options.cell))).doubt)
      findings.push_back({*doubt, Finding::Verdict::kDoubtful});
  }
  if (const char* folders = std::getenv("PATH"))
    for (Finding& finding : question_installations(own_file(), folders))
      findings.push_back(std::move(finding));
  say("{}", findings_text(findings));
  return {findings_json(findings), is_sound(findings)};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::work);
}
