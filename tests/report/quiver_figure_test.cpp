#include "planar_servo/report/quiver_figure.h"

#include <catch2/catch.hpp>
#include <stdexcept>

namespace planar {
namespace {

// Panels are 320 units wide and begin at (12, 44): the base is at (172, 204). The longest arrow of
// each is 36 units long, and the farthest point 36 units from its edge.

TEST_CASE("An arrow to +y points up, and points keep clear of the edge") {
  const std::string svg =
      quiver_svg({{"panel", {{0.0, 0.0}, {0.5, 0.5}}, {{0.0, 0.001}, {0.0, 0.0}}}});
  CHECK_THAT(svg, Catch::Contains("x1=\"172.0\" y1=\"204.0\" x2=\"172.0\" y2=\"168.0\""));
  CHECK_THAT(svg, Catch::Contains("cx=\"296.0\" cy=\"80.0\""));
}

TEST_CASE("Each panel has a scale of its own for its arrows, told by a bar below it") {
  const std::string svg = quiver_svg(
      {{"large", {{0.5, 0.0}}, {{1e-3, 0.0}}}, {"small", {{0.5, 0.0}}, {{1.5e-5, 0.0}}}});
  // Arrows from x = 296 and 296 + 332, 36 units each.
  CHECK_THAT(svg, Catch::Contains("x1=\"296.0\" y1=\"204.0\" x2=\"332.0\""));
  CHECK_THAT(svg, Catch::Contains("x1=\"628.0\" y1=\"204.0\" x2=\"664.0\""));
  // Bars of at most 60 units: 1 mm is 36; 0.02 mm, the next round length after 0.025, is 48.
  CHECK_THAT(svg, Catch::Contains(">1 mm of error<") && Catch::Contains("x2=\"48.0\""));
  CHECK_THAT(svg, Catch::Contains(">0.02 mm of error<") && Catch::Contains("x2=\"392.0\""));
}

TEST_CASE("A panel without any error has no arrows to scale") {
  CHECK_THAT(quiver_svg({{"none", {{0.5, 0.0}}, {{0.0, 0.0}}}}), !Catch::Contains("mm of error"));
}

TEST_CASE("Panels without points or with unequal sizes are refused") {
  CHECK_THROWS_AS(quiver_svg({{"empty", {}, {}}}), std::invalid_argument);
  CHECK_THROWS_AS(quiver_svg({{"uneven", {{0.0, 0.0}}, {}}}), std::invalid_argument);
}

}  // namespace
}  // namespace planar
