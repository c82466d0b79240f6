#include "planar_servo/report/html_page.h"

#include <catch2/catch.hpp>

#include "support/well_formed.h"

namespace planar {
namespace {

TEST_CASE("A page holds its parts in order and refers to no other file") {
  HtmlPage page("Run of <cell>");
  page.add_heading("One");
  page.add_paragraph("two \"quoted\"");
  page.add_html("<svg></svg>");
  const std::string text = page.text();
  CHECK_THAT(text, Catch::Contains("<title>Run of &lt;cell&gt;</title>"));
  CHECK(text.find("<h2 id=\"one-1\">One</h2>") < text.find("<p>two &quot;quoted&quot;</p>"));
  CHECK(text.find("quoted") < text.find("<svg></svg>"));
  CHECK(text.find("src=") == std::string::npos);
  CHECK(text.find("href=") == std::string::npos);
}

TEST_CASE("The contents lead to every heading that follows, those below another one indented") {
  HtmlPage page("t");
  page.add_heading("Before");
  page.add_contents();
  page.add_heading("Maps & <tables>");
  CHECK(page.add_heading("Table 1", 3) == "table-1-3");
  page.add_heading("Files");
  const std::string text = page.text();
  CHECK(test::fault_of_xml(text).empty());
  CHECK_THAT(text,
             Catch::Contains("<nav aria-label=\"On this page\">\n"
                             "<ul>\n<li><a href=\"#maps-tables-2\">Maps &amp; &lt;tables&gt;</a>"
                             "<ul>\n<li><a href=\"#table-1-3\">Table 1</a></li>\n</ul></li>\n"
                             "<li><a href=\"#files-4\">Files</a></li>\n</ul>\n</nav>\n"
                             "<h2 id=\"maps-tables-2\">"));
  CHECK(text.find("Before") < text.find("<nav"));
}

TEST_CASE("A figure and its per cent sign stay on one line") {
  HtmlPage page("t");
  page.add_paragraph("98.9 % and 90 %");
  CHECK_THAT(page.text(), Catch::Contains("<p>98.9&#160;% and 90&#160;%</p>"));
}

TEST_CASE("Lines of a paragraph stay lines") {
  HtmlPage page("t");
  page.add_paragraph("one\ntwo\n");
  CHECK_THAT(page.text(), Catch::Contains("<p>one<br/>two</p>"));
}

TEST_CASE("A page is well-formed XML and known as ours again") {
  HtmlPage page("a & b");
  page.add_paragraph("90 % of <these>\nand those");
  page.add_verdict({"well", {}});
  CHECK(test::fault_of_xml(page.text()).empty());
  CHECK_THAT(page.text(), Catch::Contains("\n<!-- format: planar-servo/page/1 -->\n"));
}

TEST_CASE("A verdict is one sentence, with what to do where it is bad") {
  HtmlPage good("t"), bad("t");
  good.add_verdict({"all is < 1 px", {}});
  CHECK_THAT(good.text(), Catch::Contains("<b>Good:</b> all is &lt; 1 px.</p></div>"));
  bad.add_verdict({"all is well", {{"a is off", "mend a"}, {"b is off", "mend b"}}});
  CHECK_THAT(bad.text(), Catch::Contains("<b>To be mended:</b> a is off; b is off.</p>") &&
                             Catch::Contains("<li>mend a.</li><li>mend b.</li>"));
  CHECK_THAT(bad.text(), !Catch::Contains("all is well"));
}

}  // namespace
}  // namespace planar
