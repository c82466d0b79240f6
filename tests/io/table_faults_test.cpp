#include "planar_servo/io/table_faults.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

using Catch::Contains;

Refusal no_number(int row) {
  return {"x is '" + std::to_string(row) + "a'", "a number is needed", std::to_string(row)};
}

TEST_CASE("Of a fault that all rows have, the first three are told, and how many more there are") {
  TableFaults faults;
  for (int row = 1; row <= 8; ++row) {
    faults.count_row();
    faults.add(no_number(row));
    if (row == 7) faults.add({"y is ''", "a number is needed", "7"});
  }
  CHECK_THROWS_WITH(faults.throw_if_any(),
                    "1: x is '1a'; a number is needed\n2: x is '2a'; a number is needed\n3: x is "
                    "'3a'; a number is needed\n7: y is ''; a number is needed\n... and 5 more");
}

TEST_CASE("A fault that a row does not have is told of every other row") {
  TableFaults faults;
  for (int row = 1; row <= 8; ++row) {
    faults.count_row();
    if (row != 4) faults.add(no_number(row));
  }
  CHECK_THROWS_WITH(faults.throw_if_any(), Contains("8: x is '8a'") && !Contains("more"));
  CHECK_NOTHROW(TableFaults().throw_if_any());
}

}  // namespace
}  // namespace planar
