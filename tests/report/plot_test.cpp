#include "planar_servo/report/plot.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <stdexcept>

#include "planar_servo/report/places.h"
#include "support/well_formed.h"

namespace planar {
namespace {

using Catch::Matchers::Contains;

// A panel's plot begins at (62, 34) and is 290 units wide and high.

TEST_CASE("Ticks are round, lie within the range and are as few as asked for") {
  for (const double range : {1e-7, 0.003, 0.77, 1.0, 42.0, 9.9e5}) {
    for (const double from : {-0.31, 0.0, 0.9}) {
      const Ticks ticks = round_ticks(from * range, (from + 1.0) * range, 7);
      INFO(range << " from " << from * range << ", step " << ticks.step);
      REQUIRE(ticks.values.size() >= 3);
      CHECK(ticks.values.size() <= 7);
      CHECK(ticks.values.front() >= from * range - 1e-9 * range);
      CHECK(ticks.values.back() <= (from + 1.0) * range + 1e-9 * range);
      const double digits = ticks.step / std::pow(10.0, std::floor(std::log10(ticks.step) + 1e-9));
      const bool is_round = std::abs(digits - 1.0) < 1e-6 || std::abs(digits - 2.0) < 1e-6 ||
                            std::abs(digits - 5.0) < 1e-6;
      CHECK(is_round);
      for (const double value : ticks.values)
        CHECK(std::abs(value / ticks.step - std::round(value / ticks.step)) < 1e-9);
    }
  }
  CHECK_THROWS_AS(round_ticks(1.0, 1.0, 5), std::invalid_argument);
}

TEST_CASE("Ticks have the decimal places of their step, and zero has no sign") {
  CHECK(round_ticks(-0.1, 0.1, 5).text(-0.05) == "-0.05");
  CHECK(round_ticks(-0.1, 0.1, 5).text(-1e-18) == "0.00");
  CHECK(round_ticks(0.0, 5000.0, 6).text(3000.0) == "3000");
}

TEST_CASE("An axis holds its values, also when they are all alike") {
  const Axis axis = axis_over("x", {3.0, -1.0, 2.0});
  CHECK(axis.from < -1.0);
  CHECK(axis.to > 3.0);
  CHECK(axis_over("x", {5.0, 5.0}).from < axis_over("x", {5.0, 5.0}).to);
  CHECK_THROWS_AS(axis_over("x", {}), std::invalid_argument);
}

double lightness(const std::string& color) {
  const auto channel = [&](std::size_t at) { return std::stoi(color.substr(at, 2), nullptr, 16); };
  return 0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5);
}

TEST_CASE("The ends of a colour scale are those of the values, and darker is more") {
  const ColorScale colors("c", {4.0, 0.5, NAN, 2.0});
  CHECK(colors.from() == 0.5);
  CHECK(colors.to() == 4.0);
  double before = 256.0;
  for (double value = 0.5; value <= 4.0; value += 0.05) {
    CHECK(lightness(colors.color(value)) < before + 0.5);  // of rounding to whole levels
    before = lightness(colors.color(value));
  }
  CHECK(colors.color(-1.0) == colors.color(0.5));
  CHECK(colors.color(9.0) == colors.color(4.0));
}

TEST_CASE("A scale of decades spaces colours by ratios and leaves out what has none") {
  const ColorScale colors("c", {0.001, 0.0, 10.0}, ColorScale::Steps::kDecades);
  CHECK(colors.from() == 0.001);
  CHECK(colors.share(0.1) == Approx(0.5));
  CHECK(colors.share(0.0) == 0.0);
  CHECK_THAT(colors.bar_svg(0.0, 0.0, 100.0), Contains(">0.001<") && Contains(">10<"));
}

TEST_CASE("Values that do not differ, and none at all, have a scale around them") {
  for (const auto steps : {ColorScale::Steps::kEven, ColorScale::Steps::kDecades})
    for (const std::vector<double>& values : {std::vector<double>{}, {0.0}, {2.0, 2.0}}) {
      const ColorScale colors("c", values, steps);
      CHECK(colors.from() < colors.to());
      CHECK_THAT(colors.bar_svg(0.0, 0.0, 100.0), Contains("<text class=\"tick\""));
    }
}

Panel unit_panel() {
  return {"a title", {"along, mm", 0.0, 2.0}, {"up, mm", 0.0, 1.0}};
}

TEST_CASE("A panel has its title, both labels and ticks in the units of its axes") {
  const std::string svg = unit_panel().svg(0.0);
  CHECK_THAT(svg, Contains(">a title<") && Contains(">along, mm<") && Contains(">up, mm<"));
  CHECK_THAT(svg, Contains(">1.5<") && Contains(">0.8<"));
}

TEST_CASE("Marks lie where the axes put them, with up being up, or down where an axis is turned") {
  Panel panel = unit_panel();
  panel.add_dots({{1.0, 0.25}});
  CHECK_THAT(panel.svg(0.0), Contains("cx=\"207.0\" cy=\"251.5\""));
  Panel picture("p", {"u", 0.0, 2.0}, {"v", 1.0, 0.0});
  picture.add_dots({{1.0, 0.25}});
  CHECK_THAT(picture.svg(0.0), Contains("cx=\"207.0\" cy=\"106.5\""));
}

TEST_CASE("An equal aspect makes a unit as long along both axes") {
  Panel panel("p", {"x", 0.0, 200.0}, {"y", 0.0, 100.0}, Panel::Aspect::kEqual);
  panel.add_dots({{100.0, 50.0}, {200.0, 100.0}});
  CHECK_THAT(panel.svg(0.0),
             Contains("cx=\"207.0\" cy=\"106.5\"") && Contains("cx=\"352.0\" cy=\"34.0\""));
}

TEST_CASE("The longest arrow is 34 units long, along the axes, and its legend tells the scale") {
  Panel panel("p", {"u", 0.0, 2.0}, {"v", 1.0, 0.0});  // v runs down
  const std::vector<Eigen::Vector2d> vectors{{0.0, 0.5}, {0.1, 0.0}};
  panel.add_arrows({{1.0, 0.5}, {1.0, 0.5}}, vectors, arrows_over(vectors, "px"));
  const std::string svg = panel.svg(0.0);
  CHECK_THAT(svg, Contains("x1=\"207.0\" y1=\"179.0\" x2=\"207.0\" y2=\"213.0\""));
  CHECK_THAT(svg, Contains("x2=\"213.8\" y2=\"179.0\""));
  CHECK_THAT(svg, Contains(">0.5 px<") && Contains("x1=\"0.0\" y1=\"-4.0\" x2=\"34.0\""));
  CHECK_THROWS_AS(panel.add_arrows({{0.0, 0.0}}, {}, arrows_over(vectors, "px")),
                  std::invalid_argument);
}

TEST_CASE("Arrows of nothing have no legend") {
  Panel panel = unit_panel();
  panel.add_arrows({{1.0, 0.5}}, {{0.0, 0.0}}, arrows_over({{0.0, 0.0}}, "mm"));
  CHECK_THAT(panel.svg(0.0), !Contains("x1=\"0.0\" y1=\"-4.0\""));
}

TEST_CASE("A field colours its cells and leaves those without a value empty") {
  Panel panel = unit_panel();
  const std::vector<Eigen::Vector2d> places = panel.field_places();
  CHECK(places.front().y() > places.back().y());
  std::vector<double> values;
  for (const Eigen::Vector2d& p : places) values.push_back(p.x() < 1.0 ? 3.0 : NAN);
  values.front() = 1.0;
  const ColorScale colors("c", values);
  panel.add_field(values, colors);
  const std::string svg = panel.svg(0.0);
  CHECK_THAT(svg, Contains(colors.color(1.0)) && Contains(colors.color(3.0)));
  CHECK_THAT(svg, Contains("x=\"62.0\" y=\"40.0\" width=\"145.4\""));  // the left half of row 2
}

TEST_CASE("Of very many marks some are drawn, and the panel says so") {
  Panel panel = unit_panel();
  panel.add_dots(std::vector<Eigen::Vector2d>(10000, {1.0, 0.5}));
  CHECK_THAT(panel.svg(0.0), Contains("drawn is one of 4, of 10000 in all"));
}

TEST_CASE("An axis of decades gives each ratio its length, with ticks at round values") {
  const Axis axis{"error, mm", 0.001, 10.0, Spacing::kDecades};
  CHECK(axis.share(0.001) == Approx(0.0));
  CHECK(axis.share(0.1) == Approx(0.5));
  CHECK(axis.share(10.0) == Approx(1.0));
  CHECK(axis.share(0.0) == Approx(0.0));
  CHECK(axis.ticks(5).values.size() == 5);
  CHECK(decade_ticks(0.9, 25.0).values == std::vector<double>{1.0, 2.0, 5.0, 10.0, 20.0});
  CHECK(axis.ticks(5).text(0.001) == "0.001");
  Panel panel("p", {"x", 0.0, 2.0}, axis);
  panel.add_dots({{1.0, 0.1}});
  CHECK_THAT(panel.svg(0.0), Contains("cx=\"207.0\" cy=\"179.0\"") && Contains(">0.01<"));
}

TEST_CASE("Decades hold the values above zero, and without any there are none") {
  const Axis axis = decades_over("x", {0.0, 0.02, -1.0, 3.0});
  CHECK((axis.from < 0.02 && axis.from > 0.01));
  CHECK((axis.to > 3.0 && axis.to < 6.0));
  CHECK_THROWS_AS(decades_over("x", {0.0, -1.0}), std::invalid_argument);
}

TEST_CASE("A scale of decades too short for round values of a decade has even ticks") {
  const Axis axis{"deviation, mm", 0.0061, 0.0088, Spacing::kDecades};
  CHECK(axis.ticks(6).values.size() >= 3);
}

TEST_CASE("Long numbers below a panel get fewer ticks than short ones, so that they do not touch") {
  const auto ticks = [](double end) {
    const std::string svg = Panel("", {"x", -end, end}, {"y", 0.0, 1.0}).svg(0.0);
    std::size_t middles = 0;
    for (std::size_t at = svg.find("y=\"339.0\" text-anchor=\"middle\""); at != std::string::npos;
         at = svg.find("y=\"339.0\" text-anchor=\"middle\"", at + 1))
      ++middles;
    return middles;
  };
  CHECK(ticks(16.0) == 7);
  CHECK(ticks(0.016) == 3);
}

TEST_CASE("Grey levels are shown as the image has them, the least black") {
  const ColorScale grey("grey level", {10.0, 200.0}, ColorScale::Steps::kEven,
                        ColorScale::Hues::kGrey);
  CHECK(grey.color(10.0) == "#000000");
  CHECK(grey.color(105.0) == "#808080");
  CHECK(grey.color(200.0) == "#ffffff");
}

/// Returns the part of a text behind `begin`, up to `end`.
std::string between(const std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t from = text.find(begin) + begin.size();
  return text.substr(from, text.find(end, from) - from);
}

TEST_CASE("Series differ by the shape of their marks and the dashes of their lines") {
  std::set<std::string> marks, lines;
  for (const char* color : kSeriesColors) {
    Panel as_mark = unit_panel(), as_line = unit_panel();
    as_mark.add_key(color, "a");
    as_line.add_key(color, "a", Panel::Sample::kLine);
    const std::string mark = between(as_mark.svg(0.0), "<g class=\"key\">", "</g>");
    const std::string line = between(as_line.svg(0.0), "<g class=\"key\">", "</g>");
    marks.insert(mark.find(" d=") == std::string::npos ? "round" : between(mark, " d=\"", "\""));
    lines.insert(line.find("dasharray") == std::string::npos ? "solid"
                                                             : between(line, "dasharray=\"", "\""));
  }
  CHECK(marks.size() == std::size(kSeriesColors));
  CHECK(lines.size() == std::size(kSeriesColors));
}

TEST_CASE("A figure says in words what it shows, its axes and its legend") {
  Panel panel("a title", {"along, mm", 0.0, 2.0}, {"up, mm", 0.0, 1.0});
  panel.add_key("#1f4e79", "ours < 1");
  const std::string svg = plot_svg({panel});
  CHECK_THAT(svg, Contains("role=\"img\"") && Contains("<title>a title</title>") &&
                      Contains("<desc>up, mm over along, mm. ours &lt; 1.</desc>"));
}

TEST_CASE("On a page each panel is a figure of its own, of the size that it is drawn for at most") {
  const std::string html = plot_html({unit_panel(), unit_panel()});
  CHECK(test::fault_of_xml(html).empty());
  CHECK_THAT(html, Contains("flex:378 1 276px;max-width:378px"));
  CHECK(html.find("<svg") != html.rfind("<svg"));
}

TEST_CASE("Lines have their colours, and a key says what a colour is") {
  Panel panel = unit_panel();
  panel.add_line({{0.0, 0.0}, {2.0, 1.0}}, Panel::Stroke::kSolid, "#123456");
  const double before = panel.height();
  panel.add_key("#123456", "the mean");
  CHECK_THAT(panel.svg(0.0), Contains("stroke=\"#123456\" d=\"M62.0 324.0 L352.0 34.0\"") &&
                                 Contains("fill=\"#123456\"") && Contains(">the mean<"));
  CHECK(panel.height() > before);
}

TEST_CASE("The bars of a histogram have round edges and count every value that they span") {
  std::vector<double> values;
  for (int i = -50; i <= 50; ++i) values.push_back(0.01 * i);
  values.push_back(40.0);
  Panel panel = histogram("h", "value", values, {0.2, "what is stated"});
  const std::string svg = panel.svg(0.0);
  CHECK_THAT(svg, Contains("curve: normal with what is stated, 0.2"));
  CHECK_THAT(svg, Contains("1 beyond the ends"));
  CHECK_THAT(plot_svg({histogram("h", "v", {1.0, 1.0}, {1.0, "s"})}), Contains("class=\"bar\""));
  CHECK_THAT(plot_svg({histogram("h", "v", {0.0, 0.0}, {0.0, "s"})}),
             Contains("class=\"bar\"") && !Contains("nan"));
}

TEST_CASE("A figure is well-formed, needs nothing from outside and holds its panels") {
  Panel panel("a < b & c", {"x", 0.0, 1.0}, {"y", 0.0, 1.0});
  panel.add_line({{0.0, 0.0}, {1.0, 1.0}}, Panel::Stroke::kDashed);
  panel.add_color_bar(ColorScale("scale", {1.0, 2.0}));
  const std::string svg = plot_svg({panel, unit_panel()});
  CHECK(test::fault_of_xml(svg).empty());
  CHECK(test::is_self_contained(svg));
  CHECK_THAT(svg, Contains("a &lt; b &amp; c") && Contains(">a title<"));
}

TEST_CASE("A file that is not well-formed is told") {
  CHECK_FALSE(test::fault_of_xml("<a><b></a></b>").empty());
  CHECK_FALSE(test::fault_of_xml("<p>a & b</p>").empty());
  CHECK_FALSE(test::fault_of_xml("<p>a<br></p>").empty());
  CHECK_FALSE(test::fault_of_xml("<p>a &nbsp; b</p>").empty());
  CHECK_FALSE(test::is_self_contained("<img src=\"a.png\"/>"));
}

}  // namespace
}  // namespace planar
