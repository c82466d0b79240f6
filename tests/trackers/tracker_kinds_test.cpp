#include <catch2/catch.hpp>
#include <fstream>
#include <thread>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/machine/trackers/tracker_kinds.h"
#include "support/line_server.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;
using Verdict = Finding::Verdict;

/// The paper's cell with these keys in its block `tracker`.
CellSettings cell_with(const test::TemporaryFolder& folder, const std::string& keys) {
  const std::string paper = read_file(test::paper_cell_file());
  return read_cell(
      folder.write("cell.yaml", test::replaced(paper, "tracker: {", "tracker: {" + keys + ", ")));
}

Finding examined(const CellSettings& cell) {
  const std::vector<Finding> findings = cell.tracker.kind->examine(cell);
  REQUIRE(findings.size() == 1);
  return findings.front();
}

TEST_CASE("A cell file says where a tracker's lines are and how they are written") {
  const test::TemporaryFolder folder;
  const CellSettings cell = cell_with(
      folder,
      "source: file, path: leica.txt, columns: {t: Time, x: X, y: Y, z: Z}, decimal_comma: true, "
      "unit: m");
  CHECK(cell.tracker.kind->name() == "file");
  const StreamDetails& details = stream_details(cell);
  CHECK(details.source == "leica.txt");
  CHECK(details.dialect.csv.renamed_columns.at("t_s") == "Time");
  CHECK(details.dialect.csv.separator == ';');
  CHECK(details.dialect.unit == 1.0);
  CHECK(cell_with(folder, "source: ask, separator: ' '").tracker.kind->name() == "ask");
}

TEST_CASE("Keys of a tracker that are missing, misspelt or wrong are refused by name") {
  const test::TemporaryFolder folder;
  const auto refuses = [&](const std::string& keys, const std::string& name,
                           Cause cause = Cause::kInvalid) {
    CAPTURE(keys);
    CHECK_THROWS_MATCHES(cell_with(folder, keys), InputError, Refused(cause, name));
  };
  refuses("source: file", "'path'", Cause::kMissing);
  refuses("source: tcp, address: nowhere", "tracker.address");
  refuses("source: ask, columns: {x: X}", "tracker.columns");
  refuses("source: file, path: a, columns: {w: X}", "tracker.columns.w");
  refuses("source: file, path: a, separator: ab", "'ab'");
  refuses("source: file, path: a, separator: ',', decimal_comma: true", "tracker.separator");
  refuses("source: file, path: a, unit: inch", "tracker.unit");
  refuses("source: theodolite", "tracker.source");
}

TEST_CASE("The doctor says of a tracker's file whether it is there, grows, is read and plausible") {
  const test::TemporaryFolder folder;
  const CellSettings cell = cell_with(folder, "source: file, path: s.csv");
  CHECK(examined(cell).verdict == Verdict::kFaulty);
  CHECK_THAT(examined(cell).fault, Contains("s.csv"));
  const auto file = folder.write("s.csv", "x_mm,y_mm,z_mm\n");
  CHECK(examined(cell).verdict == Verdict::kDoubtful);
  CHECK_THAT(examined(cell).fault, Contains("no line came"));
}

TEST_CASE("The doctor says of a tracker's port whether it answers, is read and plausible") {
  const test::TemporaryFolder folder;
  test::LineServer server;
  const CellSettings cell = cell_with(folder, "source: tcp, address: '" + server.address() + "'");
  const auto served = [&](const std::string& lines) {
    std::thread program([&] {
      server.accept_one();
      server.send("x_mm,y_mm,z_mm\n");
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      server.send(lines);
    });
    Finding finding = examined(cell);
    program.join();
    return finding;
  };
  CHECK(served("2500.1,20,30\n").verdict == Verdict::kWell);
  CHECK_THAT(served("2.5,0.2,0.3\n").remedy, Contains("unit: m"));
  CHECK_THAT(served("2500100,2,3\n").remedy, Contains("millimetres"));
  CHECK(served("2500;20;30\n").verdict == Verdict::kFaulty);
  CHECK_THAT(served("").fault, Contains("no line came"));
}

TEST_CASE("A cell whose tracker cannot be heard is not opened") {
  const test::TemporaryFolder folder;
  folder.write("truth.yaml", read_file(test::paper_cell_file().parent_path() / "truth.yaml"));
  CHECK_THROWS_AS(open_cell(cell_with(folder, "source: file, path: s.csv")), WorkError);
  folder.write("s.csv", "");
  CHECK(open_cell(cell_with(folder, "source: file, path: s.csv"))
            ->tracker()
            .readings_per_monument() == 1);
}

}  // namespace
}  // namespace planar
