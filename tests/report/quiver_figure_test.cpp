#include "report/quiver_figure.h"

#include <catch2/catch.hpp>
#include <stdexcept>

namespace planar {

TEST_CASE("An arrow to +y points up and is drawn at its magnification") {
  const std::string svg =
      quiver_svg({{"panel", {{0.0, 0.0}, {0.5, 0.5}}, {{0.0, 0.001}, {0.0, 0.0}}}}, 100.0);
  // 320 units over 2 * 1.05 * 0.5 m: 0.1 m is 30.5 units; the base is at (172, 204).
  CHECK_THAT(svg, Catch::Contains("x1=\"172.0\" y1=\"204.0\" x2=\"172.0\" y2=\"173.5\""));
}

TEST_CASE("A panel is wide enough for its longest arrow") {
  // The arrow ends at 1 m, twice as far out as its point: a margin of 1.05 leaves it inside.
  const std::string svg = quiver_svg({{"panel", {{0.5, 0.0}}, {{0.005, 0.0}}}}, 100.0);
  CHECK_THAT(svg, Catch::Contains("x2=\"324.4\""));
}

TEST_CASE("Panels without points or with unequal sizes are refused") {
  CHECK_THROWS_AS(quiver_svg({{"empty", {}, {}}}, 1.0), std::invalid_argument);
  CHECK_THROWS_AS(quiver_svg({{"uneven", {{0.0, 0.0}}, {}}}, 1.0), std::invalid_argument);
}

}  // namespace planar
