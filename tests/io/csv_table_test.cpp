#include "planar_servo/base/io/csv_table.h"

#include <catch2/catch.hpp>

#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

TEST_CASE("Columns are found by name in any order, comments and blank lines skipped") {
  const test::TemporaryFolder folder;
  const auto path = folder.write(
      "p.csv", "# format: planar-servo/pairs/1\ny,extra,x\n\n# remark\n2.5,z,-1e-3\r\n+4,z,3\n");
  CsvFile table(path, "pairs", {"x", "y"});
  REQUIRE(table.next_row());
  CHECK(table.number("x") == -1e-3);
  CHECK_FALSE(table.optional_number("absent").has_value());
  REQUIRE(table.next_row());
  CHECK(table.number("y") == 4.0);
  CHECK_FALSE(table.next_row());
  CHECK_NOTHROW(table.throw_if_faulty_or_empty());
}

TEST_CASE("Bad rows are named with file, line and value, all at once") {
  const test::TemporaryFolder folder;
  const auto path =
      folder.write("p.csv", "id,x,n\na,nan,1\nb,1.0\nc,1e999,2.5\n\n#\nd,,7\ne,+-1,7");
  CsvFile table(path, "pairs", {"id", "x"});
  while (table.next_row()) {
    table.number("x");
    table.whole_number("n");
  }
  try {
    table.throw_if_faulty();
    FAIL("no fault was found");
  } catch (const InputError& e) {
    CHECK(e.refusal() == Refusal{"x is 'nan'", "a finite number is needed", path.string() + ":2"});
    CHECK_THAT(e, Refused(Cause::kInvalid, "p.csv:3: has 2"));
    CHECK_THAT(e, Refused(Cause::kInvalid, "p.csv:4: x is '1e999'"));
    CHECK_THAT(e, Refused(Cause::kInvalid, "p.csv:4: n is '2.5'"));
    CHECK_THAT(e, Refused(Cause::kInvalid, "p.csv:7: x is ''"));
    CHECK_THAT(e, Refused(Cause::kInvalid, "p.csv:8: x is '+-1'"));
  }
}

TEST_CASE("A table without its columns, empty or of another kind is refused") {
  const test::TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    CsvFile(folder.write("p.csv", text), "pairs", {"id", "x"}).throw_if_faulty_or_empty("add one");
  };
  CHECK_THROWS_MATCHES(read(""), InputError, Refused(Cause::kMissing, "columns id, x"));
  CHECK_THROWS_MATCHES(read("# only a remark\n"), InputError,
                       Refused(Cause::kMissing, "columns id, x"));
  CHECK_THROWS_MATCHES(read("id,x\n"), InputError, Refused(Cause::kMissing, "add one"));
  CHECK_THROWS_MATCHES(read("id,y\n"), InputError, Refused(Cause::kMissing, "column x"));
  CHECK_THROWS_MATCHES(read("# format: planar-servo/lamps/1\nid,x\n"), InputError,
                       Refused(Cause::kForeign, "'planar-servo/lamps/1'"));
  CHECK_THROWS_MATCHES(read("id,x,x\n"), InputError, Refused(Cause::kExists, "'x'"));
  CHECK_THROWS_MATCHES(CsvFile(folder.path(), "pairs", {"id"}), InputError,
                       Refused(Cause::kInvalid, folder.path().string()));
  CHECK_THROWS_MATCHES(CsvFile(folder.path() / "absent.csv", "pairs", {"id"}), InputError,
                       Refused(Cause::kMissing, "absent.csv"));
}

TEST_CASE("A faulty line given by itself does not spoil the next") {
  CsvTable table("stdin", "pairs", {"id", "x"});
  CHECK_THROWS_MATCHES(table.take_line("id,y", 1), InputError,
                       Refused(Cause::kMissing, "column x"));
  CHECK_FALSE(table.has_header());
  CHECK_FALSE(table.take_line("id,x", 1));
  CHECK_FALSE(table.take_line("a,1,2", 2));
  CHECK_THROWS_MATCHES(table.throw_if_faulty(), InputError, Refused(Cause::kInvalid, "stdin:2: "));
  REQUIRE(table.take_line("a,1", 3));
  CHECK(table.number("x") == 1.0);
  table.require_id_not_in({"b"});
  CHECK_NOTHROW(table.throw_if_faulty());
  table.require_id_not_in({"a"});
  CHECK_THROWS_MATCHES(table.throw_if_faulty(), InputError, Refused(Cause::kExists, "stdin:3: "));
}

TEST_CASE("A last row without its end is refused where the table says so, and read elsewhere") {
  const test::TemporaryFolder folder;
  const auto read = [&](const std::string& text, UnendedRow unended) {
    CsvFile table(folder.write("p.csv", text), "pairs", {"id", "x"}, {}, unended);
    double last = 0.0;
    while (table.next_row()) last = table.number("x");
    table.throw_if_faulty();
    return last;
  };
  CHECK(read("id,x\na,1\nb,29", UnendedRow::kWarned) == 29.0);
  CHECK_THROWS_MATCHES(read("id,x\na,1\nb,29", UnendedRow::kRefused), InputError,
                       Refused(Cause::kInvalid, "p.csv:3: "));
  CHECK(read("id,x\na,1\n\n# remark", UnendedRow::kRefused) == 1.0);
  CHECK(read("id,x\na,1\r\n ", UnendedRow::kRefused) == 1.0);
}

TEST_CASE("Of a column that is faulty in all rows three are told, the next rows by themselves") {
  CsvTable table("p.csv", "pairs", {"id", "x"});
  table.take_line("id,x", 1);
  for (int line = 2; line < 12; ++line)
    if (table.take_line("a,?", line)) table.number("x");
  CHECK_THROWS_WITH(table.throw_if_faulty(), Contains("p.csv:4: x is '?'") &&
                                                 !Contains("p.csv:5:") &&
                                                 Contains("... and 7 more"));
  CHECK_FALSE(table.take_line("a,1,2", 12));
  CHECK_THROWS_WITH(
      table.throw_if_faulty(),
      "p.csv:12: has 3 fields; the header has 2; with decimal commas, separate columns by "
      "semicolons");
}

TEST_CASE("Of very many faults the first hundred are told, and how many more there are") {
  constexpr int kRows = 100000;
  std::string text = "id,x\na,1\n";
  for (int i = 1; i < kRows; ++i) text += "a,nan\n";
  const test::TemporaryFolder folder;
  CsvFile table(folder.write("p.csv", text), "pairs", {"id", "x"});
  while (table.next_row()) table.number("x");
  CHECK_THROWS_WITH(table.throw_if_faulty(), Contains("p.csv:102: x is 'nan'") &&
                                                 !Contains("p.csv:103:") &&
                                                 Contains("... and 99899 more"));
}

TEST_CASE("Tables of other programs are read with their separator, comma and names") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("t.csv", "Name;X [mm]\na;1,5\n");
  CsvFile table(path, "tracker", {"id", "x"}, {';', true, {{"id", "Name"}, {"x", "X [mm]"}}});
  REQUIRE(table.next_row());
  CHECK(table.text("id") == "a");
  CHECK(table.number("x") == 1.5);
  CHECK_THROWS_MATCHES(CsvFile(path, "tracker", {"id"}, {';', true, {{"id", "Name"}, {"x", "X"}}}),
                       InputError, Refused(Cause::kMissing, "'X'"));
}

TEST_CASE("A field in quotes holds separators, quotes, marks and line ends") {
  const test::TemporaryFolder folder;
  const auto path = folder.write(
      "p.csv",
      "\"id\",x,note\n \"a,b.png\" , 1,\"say \"\"yes\"\", \"\"no\"\"\"\n\"#a\",2,\"two\nlines\"\n"
      "# \"a remark\nc\"d,3,5\" wide\n");
  CsvFile table(path, "pairs", {"id", "x"});
  REQUIRE(table.next_row());
  CHECK(table.text("id") == "a,b.png");
  CHECK(table.number("x") == 1.0);
  CHECK(table.text("note") == "say \"yes\", \"no\"");
  REQUIRE(table.next_row());
  CHECK(table.text("id") == "#a");
  CHECK(table.text("note") == "two\nlines");
  REQUIRE(table.next_row());
  CHECK(table.text("id") == "c\"d");
  CHECK(table.text("note") == "5\" wide");
  table.number("note");
  CHECK_THROWS_MATCHES(table.throw_if_faulty(), InputError,
                       Refused(Cause::kInvalid, "p.csv:6: note"));
}

TEST_CASE("A quote that does not end is named by the line where it begins") {
  const test::TemporaryFolder folder;
  const auto faults = [&](const std::string& text) {
    CsvFile table(folder.write("p.csv", text), "pairs", {"id", "x"});
    while (table.next_row()) table.number("x");
    table.throw_if_faulty_or_empty();
  };
  CHECK_THROWS_MATCHES(faults("id,x\na,1\nb,\"2\nc,3\n"), InputError,
                       Refused(Cause::kInvalid, "p.csv:3: field 2"));
  CHECK_THROWS_MATCHES(faults("id,x\n\"a\"b,1\nc,two\n"), InputError,
                       Refused(Cause::kInvalid, "p.csv:2: field 1"));
  CHECK_THROWS_MATCHES(faults("id,x\n\"a\"b,1\nc,two\n"), InputError,
                       Refused(Cause::kInvalid, "p.csv:3: x is 'two'"));
  CHECK_THROWS_MATCHES(faults("id,\"x\n1,2\n"), InputError,
                       Refused(Cause::kInvalid, "p.csv:1: field 2"));
}

TEST_CASE("A long file after a quote that does not end is read in no time") {
  std::string text = "id,x\n\"a,1\n";
  for (int i = 0; i < 300000; ++i) text += "b,2\n";
  const test::TemporaryFolder folder;
  CsvFile table(folder.write("p.csv", text), "pairs", {"id", "x"});
  CHECK_FALSE(table.next_row());
  CHECK_THROWS_MATCHES(table.throw_if_faulty(), InputError,
                       Refused(Cause::kInvalid, "p.csv:2: field 1"));
}

TEST_CASE("Only a text that would be read otherwise is quoted") {
  CHECK(csv_field("a b.png") == "a b.png");
  CHECK(csv_field("c#1;d'") == "c#1;d'");
  CHECK(csv_field("a,b") == "\"a,b\"");
  CHECK(csv_field("5\"") == "\"5\"\"\"");
  CHECK(csv_field("#1") == "\"#1\"");
  CHECK(csv_field(" a") == "\" a\"");
  CHECK(csv_field("a\nb") == "\"a\nb\"");
}

}  // namespace
}  // namespace planar
