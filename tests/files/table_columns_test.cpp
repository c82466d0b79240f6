#include "planar_servo/tables/table_columns.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/core/error.h"
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

}  // namespace
}  // namespace planar
