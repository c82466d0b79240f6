#include "planar_servo/report/text_table.h"

#include <catch2/catch.hpp>
#include <stdexcept>

namespace planar {
namespace {

TEST_CASE("A table aligns its first column left and the others right, also with wide characters") {
  TextTable table("Title", {"what", "mm"});
  table.add_row({"(200, −200)", "0.1"});
  table.add_row({"a", "10.25"});
  CHECK(table.plain_text() ==
        "Title\n"
        "  what            mm\n"
        "  (200, −200)    0.1\n"
        "  a            10.25\n");
}

TEST_CASE("A table's HTML escapes its cells") {
  TextTable table("a < b", {"x"});
  table.add_row({"1 & 2"});
  CHECK(table.html() ==
        "<table>\n<caption>a &lt; b</caption>\n<tr><th>x</th></tr>\n<tr><td>1 &amp; 2</td></tr>\n"
        "</table>\n");
}

TEST_CASE("A row with a missing cell is refused") {
  TextTable table("t", {"a", "b"});
  CHECK_THROWS_AS(table.add_row({"1"}), std::logic_error);
}

}  // namespace
}  // namespace planar
