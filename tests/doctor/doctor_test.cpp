#include "planar_servo/console/doctor/doctor.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;
using Verdict = Finding::Verdict;

TEST_CASE("A virtual cell in order only lacks the files that are not made yet") {
  const auto findings = examine_cell(test::paper_cell_file());
  CHECK(findings.size() == 11);
  for (const Finding& finding : findings) {
    CHECK(finding.verdict == Verdict::kWell);
    CHECK(finding.remedy.empty());
  }
  CHECK(findings.back().where == "tracker");
  CHECK_THAT(findings.back().fault, Contains("virtual") && Contains("no device to examine"));
}

TEST_CASE("The levels of two lamps in view are shown, and judged where they are cut") {
  const auto devices = open_cell(read_cell(test::paper_cell_file()));
  const auto findings = examine_lamps(devices->camera());
  REQUIRE(findings.size() == 2);
  for (const Finding& finding : findings) {
    CHECK_THAT(finding.where, Contains("lamp at ("));
    CHECK_THAT(finding.fault, Contains("levels 0 [") && Contains("ambient 1"));
    CHECK(finding.verdict == Verdict::kWell);
  }
  devices->camera().set_exposure({1.0, 0.0});  // 100 times the usual light
  CHECK_THAT(examine_lamps(devices->camera()).at(0).remedy, Contains("expose less"));
}

TEST_CASE("A cell file with faults is refused with all of them") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("cell.yaml", "format: planar-servo/cell/1\ncamera: 3\n");
  CHECK_THROWS_MATCHES(examine_cell(file), InputError, Refused(Cause::kInvalid, "camera"));
  CHECK_THROWS_MATCHES(examine_cell(file), InputError, Refused(Cause::kMissing, "'drives'"));
}

TEST_CASE("A virtual camera with real drives is refused, as by the programs that move them") {
  const test::TemporaryFolder folder;
  std::string text = read_file(test::paper_cell_file());
  const std::string kind = "kind: virtual,";
  text.replace(
      text.find(kind), kind.size(),
      "kind: tic, serial: \"1\", command_timeout_ms: 1000, home: {reference: taught, at_deg: 0},");
  CHECK_THROWS_MATCHES(examine_cell(folder.write("cell.yaml", text)), InputError,
                       Refused(Cause::kContradiction, "camera.source"));
}

/// The findings of this verdict about a file of the calibrated workshop cell, with `name` of it
/// written anew.
std::vector<Finding> faults_with(const std::string& name, const std::string& text) {
  const test::TemporaryFolder folder;
  std::filesystem::copy(test::workshop_cell_file().parent_path(), folder.path(),
                        std::filesystem::copy_options::recursive);
  folder.write(name, text);
  std::vector<Finding> faults;
  for (const Finding& finding : examine_cell(folder / "cell.yaml"))
    if (finding.verdict == Verdict::kFaulty) faults.push_back(finding);
  return faults;
}

TEST_CASE("A file that the servo could not read is faulty, and says what mends it") {
  for (const auto& [name, program] : {std::pair("health.yaml", "planar-pair-tracker"),
                                      {"tool.yaml", "planar-pair-tracker"},
                                      {"workplane.yaml", "planar-pair-tracker"},
                                      {"map.yaml", "planar-fit-error-map"},
                                      {"camera.yaml", "planar-calibrate-camera"}}) {
    INFO(name);
    bool is_told = false;
    for (const Finding& fault : faults_with(name, ""))
      is_told =
          is_told || (fault.where == name && fault.fault.find("is empty") != std::string::npos &&
                      fault.remedy == std::string("make it again with ") + program);
    CHECK(is_told);
  }
}

TEST_CASE("A tool's file that the servo could not read is faulty, one not taught yet is told") {
  const test::TemporaryFolder folder;
  std::filesystem::copy(test::workshop_cell_file().parent_path(), folder.path(),
                        std::filesystem::copy_options::recursive);
  folder.write("needle.yaml", "");
  const std::string tools = "\ntools: {needle: needle.yaml, drill: drill.yaml}\n";
  folder.write("cell.yaml", read_file(folder / "cell.yaml") + tools);
  bool is_faulty = false, is_absent = false;
  for (const Finding& finding : examine_cell(folder / "cell.yaml")) {
    is_faulty =
        is_faulty || (finding.where == "needle.yaml" && finding.verdict == Verdict::kFaulty);
    is_absent = is_absent || (finding.where == "drill.yaml" && finding.verdict == Verdict::kWell &&
                              finding.fault.find("planar-teach-tool") != std::string::npos);
  }
  CHECK(is_faulty);
  CHECK(is_absent);
}

TEST_CASE("A workplane without the cell's reference lamps is faulty, as for the servo") {
  const std::string workplane =
      read_file(test::workshop_cell_file().parent_path() / "workplane.yaml");
  const std::size_t lamps = workplane.find("\nreference_lamps:");
  REQUIRE(lamps != std::string::npos);
  const auto faults = faults_with("workplane.yaml", workplane.substr(0, lamps + 1));
  bool is_told = false;
  for (const Finding& fault : faults)
    is_told = is_told || fault.fault.find("knows none of the") != std::string::npos;
  CHECK(is_told);
}

}  // namespace
}  // namespace planar
