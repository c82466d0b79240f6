#include "planar_servo/doctor/doctor.h"

#include <catch2/catch.hpp>

#include "planar_servo/core/error.h"
#include "planar_servo/io/atomic_file.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using Verdict = Finding::Verdict;

TEST_CASE("A virtual cell in order only lacks the files that are not made yet") {
  const auto findings = examine_cell(test::paper_cell_file());
  CHECK(findings.size() == 11);
  for (const Finding& finding : findings) {
    const bool is_file = finding.subject.find(".yaml") != std::string::npos;
    CHECK(finding.verdict == (is_file ? Verdict::kDoubtful : Verdict::kWell));
    CHECK(finding.remedy.empty() != is_file);
  }
  CHECK(findings.back().subject == "tracker");
  CHECK_THAT(findings.back().what, Contains("virtual") && Contains("no device to examine"));
}

TEST_CASE("A cell file with faults is refused with all of them") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("cell.yaml", "format: planar-servo/cell/1\ncamera: 3\n");
  CHECK_THROWS_AS(examine_cell(file), InputError);
  CHECK_THROWS_WITH(examine_cell(file), Contains("camera") && Contains("'drives'"));
}

TEST_CASE("A virtual camera with real drives is refused, as by the programs that move them") {
  const test::TemporaryFolder folder;
  std::string text = read_file(test::paper_cell_file());
  const std::string kind = "kind: virtual,";
  text.replace(
      text.find(kind), kind.size(),
      "kind: tic, serial: \"1\", command_timeout_ms: 1000, home: {reference: taught, at_deg: 0},");
  CHECK_THROWS_WITH(examine_cell(folder.write("cell.yaml", text)),
                    Contains("a virtual camera needs virtual drives"));
}

}  // namespace
}  // namespace planar
