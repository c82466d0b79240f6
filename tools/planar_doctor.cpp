#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "planar_servo/doctor/doctor.h"
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

const char* name(Finding::Verdict verdict) {
  switch (verdict) {
    case Finding::Verdict::kWell:
      return "well";
    case Finding::Verdict::kDoubtful:
      return "doubtful";
    case Finding::Verdict::kFaulty:
      break;
  }
  return "faulty";
}

Outcome work(const Options& options) {
  const auto findings = examine_cell(options.cell);
  nlohmann::json rows = nlohmann::json::array();
  for (const Finding& finding : findings) {
    fmt::print("{:9} {}: {}\n", name(finding.verdict), finding.subject, finding.what);
    if (!finding.remedy.empty()) fmt::print("          -> {}\n", finding.remedy);
    rows.push_back({{"verdict", name(finding.verdict)},
                    {"subject", finding.subject},
                    {"what", finding.what},
                    {"remedy", finding.remedy}});
  }
  const bool sound = std::none_of(findings.begin(), findings.end(), [](const Finding& finding) {
    return finding.verdict == Finding::Verdict::kFaulty;
  });
  return {{{"findings", rows}}, sound};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::work);
}
