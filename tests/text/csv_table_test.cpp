#include "text/csv_table.h"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;

TEST_CASE("Columns are found by name in any order, comments and blank lines skipped") {
  const test::TemporaryFolder folder;
  const auto path = folder.write(
      "p.csv", "# format: planar-servo/pairs/1\ny,extra,x\n\n# remark\n2.5,z,-1e-3\r\n+4,z,3\n");
  CsvTable table = CsvTable::read(path, "pairs", {"x", "y"});
  REQUIRE(table.size() == 2);
  CHECK(table.number(0, "x") == -1e-3);
  CHECK(table.number(1, "y") == 4.0);
  CHECK(table.line(1) == 6);
  CHECK_FALSE(table.optional_number(0, "absent").has_value());
  CHECK_NOTHROW(table.throw_if_faulty());
}

TEST_CASE("Bad rows are named with file, line and value, all at once") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("p.csv", "id,x,n\na,nan,1\nb,1.0\nc,1e999,2.5\nd,,7\n");
  CsvTable table = CsvTable::read(path, "pairs", {"id", "x"});
  for (std::size_t row = 0; row < table.size(); ++row) {
    table.number(row, "x");
    table.whole_number(row, "n");
  }
  try {
    table.throw_if_faulty();
    FAIL("no fault was found");
  } catch (const InputError& e) {
    CHECK_THAT(e.what(), Contains("p.csv:2: x is 'nan'; a finite number is needed"));
    CHECK_THAT(e.what(), Contains("p.csv:3: has 2 fields; the header has 3"));
    CHECK_THAT(e.what(), Contains("p.csv:4: x is '1e999'"));
    CHECK_THAT(e.what(), Contains("p.csv:4: n is '2.5'; a whole number is needed"));
    CHECK_THAT(e.what(), Contains("p.csv:5: x is ''"));
  }
}

TEST_CASE("A table without its columns, empty or of another kind is refused") {
  const test::TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    return CsvTable::read(folder.write("p.csv", text), "pairs", {"id", "x"});
  };
  CHECK_THROWS_WITH(read(""), Contains("p.csv: is empty") && Contains("id, x"));
  CHECK_THROWS_WITH(read("id,y\n"), Contains("lacks the column x"));
  CHECK_THROWS_WITH(read("# format: planar-servo/lamps/1\nid,x\n"),
                    Contains("'planar-servo/lamps/1'") && Contains("planar-servo/pairs/1"));
  CHECK_THROWS_WITH(read("id,x,x\n"), Contains("the column 'x' stands twice"));
}

TEST_CASE("Tables of other programs are read with their separator, comma and names") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("t.csv", "Name;X [mm]\na;1,5\n");
  CsvTable table =
      CsvTable::read(path, "tracker", {"id", "x"}, {';', true, {{"id", "Name"}, {"x", "X [mm]"}}});
  CHECK(table.text(0, "id") == "a");
  CHECK(table.number(0, "x") == 1.5);
}

TEST_CASE("A written table is read back, and a short row is refused") {
  CsvWriter writer("pairs", {"id", "x", "note"});
  writer.add("a").add(1.23456, 3).add_empty().end_row();
  CHECK(writer.text() == "# format: planar-servo/pairs/1\nid,x,note\na,1.235,\n");
  writer.add("b");
  CHECK_THROWS_AS(writer.end_row(), std::logic_error);
}

}  // namespace
}  // namespace planar
