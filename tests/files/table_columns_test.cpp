#include "planar_servo/files/tables/table_columns.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

TEST_CASE("A table is read by columns, without the optional ones that it lacks") {
  const test::TemporaryFolder folder;
  const auto path = folder.write(
      "t.csv",
      "# format: planar-servo/targets/1\nphi_deg,id,x_mm,y_mm,more\n,a,1.5,2,x\n90,b,3,4,y\n");
  REQUIRE(table_kind_of(path) == "targets");
  const auto columns = read_table_columns(path, "targets");
  REQUIRE(columns.size() == 4);
  CHECK(columns[0].name == "id");
  CHECK(columns[0].texts == std::vector<std::string>{"a", "b"});
  CHECK(columns[1].numbers == std::vector<double>{1.5, 3.0});
  CHECK(std::isnan(columns[3].numbers.at(0)));
  CHECK(columns[3].numbers.at(1) == 90.0);
  CHECK(read_table_columns(folder.write("t.csv", "id,x_mm,y_mm\na,1,2\n"), "targets").size() == 3);
}

TEST_CASE("Reading by columns refuses what reading by rows does, and a kind that is none") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("t.csv", "id,x_mm,y_mm\na,1,NaN\nb,,2\n");
  for (const char* place : {"t.csv:2: y_mm", "t.csv:3: x_mm"})
    CHECK_THROWS_MATCHES(read_table_columns(path, "targets"), InputError,
                         Refused(Cause::kInvalid, place));
  CHECK_THROWS_MATCHES(read_table_columns(path, "target"), InputError,
                       Refused(Cause::kInvalid, "'target'"));
  CHECK(table_kind_of(path).empty());
}

TEST_CASE("Reading by columns wants ids of their own where reading by rows does") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("t.csv", "id,x_mm,y_mm\na,1,2\na,3,4\n");
  CHECK_THROWS_MATCHES(read_table_columns(path, "targets"), InputError,
                       Refused(Cause::kExists, "t.csv:3: the id 'a'"));
}

TEST_CASE("A table is written with all digits, in the order of its kind, and read back") {
  std::vector<TableColumn> columns = columns_named({"y_mm", "phi_deg", "x_mm", "id"}, "targets");
  REQUIRE(columns.size() == 4);
  columns[0].texts = {"a", "b,c"};
  columns[1].numbers = {0.1 + 0.2, -0.0};
  columns[2].numbers = {1.0, 1e-9};
  columns[3].numbers = {std::nan(""), 90.0};
  const std::string text = table_text(columns, "targets");
  CHECK(text ==
        "# format: planar-servo/targets/1\nid,x_mm,y_mm,phi_deg\n"
        "a,0.30000000000000004,1,\n\"b,c\",0,1e-09,90\n");
  const test::TemporaryFolder folder;
  const auto read = read_table_columns(folder.write("t.csv", text), "targets");
  CHECK(read.at(0).texts == columns[0].texts);
  CHECK(read.at(1).numbers == columns[1].numbers);
}

TEST_CASE("A table that its reader would refuse is not written") {
  CHECK_THROWS_MATCHES(columns_named({"id", "x_mm", "y"}, "targets"), InputError,
                       Refused(Cause::kMissing, "y is probably y_mm"));
  CHECK_THROWS_MATCHES(columns_named({"id", "x_mm", "y_mm", "colour"}, "targets"), InputError,
                       Refused(Cause::kInvalid, "'colour'"));
  CHECK_THROWS_MATCHES(columns_named({}, "targets"), InputError,
                       Refused(Cause::kMissing, "table: "));
  CHECK_THROWS_MATCHES(columns_named({"id"}, "target"), InputError,
                       Refused(Cause::kInvalid, "kind: 'target'"));
  std::vector<TableColumn> columns = columns_named({"id", "x_mm", "y_mm"}, "targets");
  CHECK_THROWS_MATCHES(table_text(columns, "targets"), InputError,
                       Refused(Cause::kMissing, "table: "));
  columns[0].texts = {"a", "a"};
  columns[1].numbers = {0.0, std::nan("")};
  columns[2].numbers = {HUGE_VAL, 0.0};
  for (const char* place : {"table[0]: y_mm", "table[1]: x_mm"})
    CHECK_THROWS_MATCHES(table_text(columns, "targets"), InputError,
                         Refused(Cause::kInvalid, place));
  CHECK_THROWS_MATCHES(table_text(columns, "targets"), InputError,
                       Refused(Cause::kExists, "table[1]: the id 'a'"));
}

}  // namespace
}  // namespace planar
