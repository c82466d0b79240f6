#include "app/doctor.h"

#include <catch2/catch.hpp>

#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using Verdict = Finding::Verdict;

}  // namespace

TEST_CASE("A virtual cell in order has nothing to mend") {
  const auto findings = examine_cell(test::paper_cell_file());
  CHECK(findings.size() == 4);
  for (const Finding& finding : findings) {
    CHECK(finding.verdict == Verdict::kWell);
    CHECK(finding.remedy.empty());
  }
}

TEST_CASE("Every fault of a cell file is a finding of its own") {
  const test::TemporaryFolder folder;
  const auto findings =
      examine_cell(folder.write("cell.yaml", "format: planar-servo/cell/1\ncamera: 3\n"));
  CHECK(findings.size() > 5);
  for (const Finding& finding : findings) CHECK(finding.verdict == Verdict::kFaulty);
}

TEST_CASE("Little memory for USB is doubtful, with the command that gives more") {
  const test::TemporaryFolder folder;
  const Finding little = examine_usb_memory(folder.write("usbfs_memory_mb", "16\n"));
  CHECK(little.verdict == Verdict::kDoubtful);
  CHECK_THAT(little.remedy, Contains("echo 1000 | sudo tee"));
  CHECK(examine_usb_memory(folder.write("usbfs_memory_mb", "1000\n")).verdict == Verdict::kWell);
  CHECK(examine_usb_memory(folder.path() / "absent").verdict == Verdict::kDoubtful);
}

}  // namespace planar
