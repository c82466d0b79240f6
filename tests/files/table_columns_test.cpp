#include "planar_servo/files/tables/table_columns.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;

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
  CHECK_THROWS_WITH(read_table_columns(path, "targets"),
                    Contains("t.csv:2: y_mm is 'NaN'") && Contains("t.csv:3: x_mm is ''"));
  CHECK_THROWS_WITH(read_table_columns(path, "target"), Contains("allowed are cycles, error_grid"));
  CHECK(table_kind_of(path).empty());
}

TEST_CASE("Reading by columns wants ids of their own where reading by rows does") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("t.csv", "id,x_mm,y_mm\na,1,2\na,3,4\n");
  CHECK_THROWS_WITH(read_table_columns(path, "targets"), Contains("t.csv:3: the id 'a' stands"));
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
  CHECK_THROWS_WITH(columns_named({"id", "x_mm", "y"}, "targets"),
                    Contains("table: lacks the column y_mm") && Contains("y is probably y_mm"));
  CHECK_THROWS_WITH(columns_named({"id", "x_mm", "y_mm", "colour"}, "targets"),
                    Contains("table: has a column 'colour'"));
  CHECK_THROWS_WITH(columns_named({}, "targets"), Contains("table: has no columns"));
  CHECK_THROWS_WITH(columns_named({"id"}, "target"), Contains("kind: 'target' is no kind"));
  std::vector<TableColumn> columns = columns_named({"id", "x_mm", "y_mm"}, "targets");
  CHECK_THROWS_WITH(table_text(columns, "targets"), Contains("table: has no rows"));
  columns[0].texts = {"a", "a"};
  columns[1].numbers = {0.0, std::nan("")};
  columns[2].numbers = {HUGE_VAL, 0.0};
  CHECK_THROWS_WITH(table_text(columns, "targets"),
                    Contains("table[0]: y_mm is 'inf'") && Contains("table[1]: x_mm is ''") &&
                        Contains("table[1]: the id 'a' stands twice"));
}

}  // namespace
}  // namespace planar
