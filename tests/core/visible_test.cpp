#include "planar_servo/base/core/text.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

TEST_CASE("What would control a terminal is shown, and a text as it is") {
  CHECK(visible("\x1b]0;title\x07id\r") == "\\x1b]0;title\\x07id\\x0d");
  CHECK(visible("\x7f\xc2\x9b"
                "2J") == "\\x7f\\x9b2J");
  CHECK(visible("90\u00b0, 5 \u00b5m\n\tnext") == "90\u00b0, 5 \u00b5m\n\tnext");
  CHECK(visible(std::string_view("\0a", 2)) == "\\x00a");
}

}  // namespace
}  // namespace planar
