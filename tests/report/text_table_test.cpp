#include "planar_servo/report/report_list.h"

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

TEST_CASE("A table's HTML escapes its cells, and says what heads a column and what a row") {
  TextTable table("a < b", {"x", "y"});
  table.add_row({"1 & 2", "3"});
  CHECK(table.html() ==
        "<table>\n<caption>a &lt; b</caption>\n<thead>\n<tr><th scope=\"col\">x</th>"
        "<th scope=\"col\">y</th></tr>\n</thead>\n<tbody>\n"
        "<tr><th scope=\"row\">1 &amp; 2</th><td>3</td></tr>\n</tbody>\n</table>\n");
  CHECK(table.html("title-1").find("<table aria-labelledby=\"title-1\">\n<thead>") == 0);
}

TEST_CASE("A table of facts has no empty heads, and a broad one scrolls by itself") {
  TextTable facts("Facts", {"", ""}), broad("Broad", {"", "b", "c"});
  facts.add_row({"mean", "1 mm"});
  broad.add_row({"", "2", "3"});
  CHECK(facts.html() ==
        "<table class=\"facts\">\n<caption>Facts</caption>\n<tbody>\n"
        "<tr><th scope=\"row\">mean</th><td>1 mm</td></tr>\n</tbody>\n</table>\n");
  CHECK_THAT(broad.html(), Catch::StartsWith("<div class=\"wide\" role=\"region\" "
                                             "aria-label=\"Broad\" tabindex=\"0\">\n<table>"));
  CHECK_THAT(broad.html(), Catch::Contains("<tr><td></td><th scope=\"col\">b</th>") &&
                               Catch::Contains("<tr><td></td><td>2</td>"));
}

TEST_CASE("A row with a missing cell is refused") {
  TextTable table("t", {"a", "b"});
  CHECK_THROWS_AS(table.add_row({"1"}), std::logic_error);
}

}  // namespace
}  // namespace planar
