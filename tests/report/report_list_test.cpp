#include "planar_servo/report/report_list.h"

#include <catch2/catch.hpp>
#include <limits>
#include <stdexcept>

#include "planar_servo/base/io/columns.h"

namespace planar {
namespace {

using Catch::Contains;

TEST_CASE("A figure of a list is printed and written in the unit of its key") {
  ReportList list;
  list.line("vision error", "{raw_rms_mm:.4f} mm rms, {turn_deg:.1f} deg", 77.5e-6, -3.14159265);
  list.line("scale", "{scale_ppm:.1f} ppm of {n} pairs", 2e-6, 12);
  CHECK(list.text() ==
        "vision error        0.0775 mm rms, -180.0 deg\n"
        "scale               2.0 ppm of 12 pairs\n");
  CHECK(list.json()["raw_rms_mm"].get<double>() == Approx(0.0775));
  CHECK(list.json()["n"] == 12);
}

TEST_CASE("Shares, vectors, words and small negative numbers are printed as people read them") {
  ReportList list;
  list.line("", "{gain:.1%}, ({p_mm:.2f}), {rms_95_mm:.1f| to }, {method:<5}|, {zero:.2f}", 0.874,
            Eigen::Vector2d(1e-3, -2e-3), std::pair(1e-3, 2e-3), "rbf", -0.001);
  CHECK(list.text() == "87.4 %, (1.00, -2.00), 1.0 to 2.0, rbf  |, 0.00\n");
  CHECK(list.json()["gain"] == 0.874);
}

TEST_CASE("A figure that is not known takes its line away, and its key if there is none") {
  ReportList list;
  list.line("noise", "{noise_mm:.4f} mm", std::numeric_limits<double>::quiet_NaN());
  list.line("turn", "{turn_deg:.4f} deg", std::optional<double>());
  list.line_if(false, "unattended", "{n_unattended} poses", 0);
  list.unprinted("seconds", 1.5);
  CHECK(list.text().empty());
  CHECK(list.json().dump() == R"({"n_unattended":0,"noise_mm":null,"seconds":1.5})");
}

TEST_CASE("The rows of a list are lines, an array and a table") {
  ReportList list;
  const auto list_number = [](ReportList& row, double number) {
    row.line("what", "number {number:g}", number);
    row.line("half", "{half:g}", number > 1.0 ? std::optional(number / 2.0) : std::nullopt);
  };
  list.rows("numbers", std::vector<double>{1.0, 4.0}, list_number, "  ");
  CHECK(list.text() == "  number 1\n  number 4: 2\n");
  CHECK(list.json().dump() == R"({"numbers":[{"number":1.0},{"half":2.0,"number":4.0}]})");
  list.show("numbers", "Numbers");
  CHECK_THAT(list.table_html("numbers"),
             Contains("<th scope=\"col\">what</th><th scope=\"col\">half</th>") &&
                 Contains("<th scope=\"row\">number 1</th><td>–</td>") &&
                 Contains("<th scope=\"row\">number 4</th><td>2</td>"));
}

TEST_CASE("A table is shown on a page and, where that is asked for, in print") {
  ReportList list;
  list.line("method", "rbf");
  ReportList& row = list.row("terms");
  row.line("term", "{name}", "link 1");
  row.line("value", "{value:.2f} +- {sigma:.2f} mm", 149.6, 0.5);
  list.row("terms", {{"", "and no more"}});
  list.show("terms", "Terms", ReportList::Shown::kAlsoInPrint);
  list.row("more", {{"what", "on the page alone"}});
  list.show("more", "More");
  list.show("none", "Without rows", ReportList::Shown::kAlsoInPrint);
  CHECK(list.text() ==
        "method              rbf\n"
        "\n"
        "Terms\n"
        "  term                     value\n"
        "  link 1       149.60 +- 0.50 mm\n"
        "  and no more\n");
  CHECK(list.json().empty());
  CHECK_THAT(list.html("Found"),
             Contains("<caption>Found</caption>") &&
                 Contains("<th scope=\"row\">link 1</th><td>149.60 +- 0.50 mm</td>") &&
                 Contains("<th scope=\"row\">and no more</th><td></td>") &&
                 Contains("on the page alone") && !Contains("Without rows"));
  CHECK_THAT(list.facts("Found").html(), !Contains("link 1") && !Contains("term"));
  CHECK(list.table_html("none").empty());
  CHECK_THROWS_AS(list.table("others"), std::logic_error);
}

TEST_CASE("A table's columns of CSV have their names there, with the digits that people read") {
  Columns csv;
  std::string id = "a";
  double x = 0.26;
  std::optional<double> unknown;
  csv.text("target", id);
  csv.number("x_mm", x, 1e-3, 6);
  csv.optional_number("after_truth_mm", unknown, 1e-3, 6);
  ReportList list;
  list.row("targets", csv, {{"target"}, {"after_truth_mm", 4}, {"x_mm", 1}});
  list.show("targets", "Targets");
  CHECK_THAT(list.table_html("targets"),
             Contains("<th scope=\"col\">after truth mm</th><th scope=\"col\">x mm</th>") &&
                 Contains("<th scope=\"row\">a</th><td>–</td><td>260.0</td>"));
  CHECK_THROWS_AS(list.row("targets", csv, {{"y_mm", 1}}), std::logic_error);
}

TEST_CASE("Parts have a key of their own, and a suffix says who judged") {
  ReportList list, judged("_truth"), part;
  part.line("mean", "{mean_mm:.1f} mm", 1e-3);
  judged.part("workspace", part);
  judged.unprinted("max_mm", 2e-3);
  list.append(judged);
  CHECK(list.text() == "mean                1.0 mm\n");
  CHECK(list.json().dump() == R"({"max_mm_truth":2.0,"workspace_truth":{"mean_mm":1.0}})");
  CHECK_THAT(list.facts("Found").html(),
             Contains("<tr><th scope=\"row\">mean</th><td>1.0 mm</td></tr>"));
}

TEST_CASE("A key without a figure and a figure without a key are mistakes of a program") {
  ReportList list;
  CHECK_THROWS_AS(list.line("", "{a} {b}", 1), std::logic_error);
  CHECK_THROWS_AS(list.line("", "{a}", 1, 2), std::logic_error);
  CHECK_NOTHROW(list.line("", "a file named {a}"));
}

}  // namespace
}  // namespace planar
