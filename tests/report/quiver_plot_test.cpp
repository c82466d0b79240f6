#include "planar_servo/report/plot.h"

#include <catch2/catch.hpp>
#include <regex>
#include <stdexcept>

#include "support/well_formed.h"

namespace planar {
namespace {

using Catch::Contains;

std::size_t count_of(const std::string& part, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

std::string quiver_svg(const std::vector<QuiverPanel>& panels) {
  return plot_svg(quiver_panels(panels));
}

TEST_CASE("Before and after share axes, arrows and colours") {
  const std::string svg = quiver_svg({{"before", {{0.5, 0.0}, {-0.5, 0.5}}, {{1e-3, 0.0}, {0, 0}}},
                                      {"after", {{0.5, 0.0}}, {{1e-5, 0.0}}}});
  CHECK(test::fault_of_xml(svg).empty());
  CHECK(count_of(">x, mm<", svg) == 2);
  CHECK(count_of(">400<", svg) == 4);  // a tick of both axes of both panels
  CHECK(count_of(">error, mm<", svg) == 1);
  CHECK(count_of(">1 mm<", svg) == 2);  // the arrows' legend
  // One dot at x = 500 mm in each panel, and arrows of 34 and 0.3 units from there.
  CHECK_THAT(svg, Contains(">0.01<") && Contains(">1<"));  // ends of the colours
}

TEST_CASE("Arrows at the edge that point outwards end within the frame") {
  const std::string svg = quiver_svg({{"outwards",
                                       {{0.5, 0.0}, {-0.5, 0.0}, {0.0, 0.2}, {0.0, -0.2}},
                                       {{1e-3, 0.0}, {-1e-3, 0.0}, {0.0, 1e-3}, {0.0, -1e-3}}}});
  const std::regex frame(
      "class=\"frame\" x=\"([0-9.]+)\" y=\"([0-9.]+)\" "
      "width=\"([0-9.]+)\" height=\"([0-9.]+)\"");
  const std::regex arrow("class=\"arrow\" [^>]*x2=\"([0-9.]+)\" y2=\"([0-9.]+)\"");
  std::smatch of_frame;
  REQUIRE(std::regex_search(svg, of_frame, frame));
  const double left = std::stod(of_frame[1]), top = std::stod(of_frame[2]);
  const double right = left + std::stod(of_frame[3]), bottom = top + std::stod(of_frame[4]);
  int arrows = 0;
  for (std::sregex_iterator found(svg.begin(), svg.end(), arrow), end; found != end; ++found) {
    const double x = std::stod((*found)[1]), y = std::stod((*found)[2]);
    if (y < 0.0) continue;
    INFO("arrow to " << x << ", " << y);
    CHECK((x >= left && x <= right && y >= top && y <= bottom));
    ++arrows;
  }
  CHECK(arrows == 4);
}

TEST_CASE("A panel without any error has no arrows to scale") {
  CHECK_THAT(quiver_svg({{"none", {{0.5, 0.0}}, {{0.0, 0.0}}}}), !Contains("y1=\"-4.0\""));
}

TEST_CASE("Panels without points or with unequal sizes are refused") {
  CHECK_THROWS_AS(quiver_panels({{"empty", {}, {}}}), std::invalid_argument);
  CHECK_THROWS_AS(quiver_panels({{"uneven", {{0.0, 0.0}}, {}}}), std::invalid_argument);
}

}  // namespace
}  // namespace planar
