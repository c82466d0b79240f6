#include "planar_servo/report/html_page.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

TEST_CASE("A page holds its parts in order and refers to no other file") {
  HtmlPage page("Run of <cell>");
  page.add_heading("One");
  page.add_paragraph("two \"quoted\"");
  page.add_html("<svg></svg>");
  const std::string text = page.text();
  CHECK_THAT(text, Catch::Contains("<title>Run of &lt;cell&gt;</title>"));
  CHECK(text.find("<h2>One</h2>") < text.find("<p>two &quot;quoted&quot;</p>"));
  CHECK(text.find("quoted") < text.find("<svg></svg>"));
  CHECK(text.find("src=") == std::string::npos);
  CHECK(text.find("href=") == std::string::npos);
}

TEST_CASE("A figure and its per cent sign stay on one line") {
  HtmlPage page("t");
  page.add_paragraph("98.9 % and 90 %");
  CHECK_THAT(page.text(), Catch::Contains("<p>98.9&nbsp;% and 90&nbsp;%</p>"));
}

TEST_CASE("Lines of a paragraph stay lines") {
  HtmlPage page("t");
  page.add_paragraph("one\ntwo\n");
  CHECK_THAT(page.text(), Catch::Contains("<p>one<br>two</p>"));
}

}  // namespace
}  // namespace planar
