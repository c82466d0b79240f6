#include "planar_servo/base/core/text.h"

#include <catch2/catch.hpp>
#include <limits>

namespace planar {
namespace {

TEST_CASE("What rounds to zero has no sign, everything else keeps its own") {
  CHECK(fixed(-0.0, 3) == "0.000");
  CHECK(fixed(-0.0004, 3) == "0.000");
  CHECK(fixed(-0.0006, 3) == "-0.001");
  CHECK(fixed(-0.4, 0) == "0");
  CHECK(fixed(-10.0, 0) == "-10");
  CHECK(fixed(0.0004, 3) == "0.000");
  CHECK(fixed(-std::numeric_limits<double>::infinity(), 1) == "-inf");
}

TEST_CASE("Several values stand between their separators") {
  CHECK(fixed(Eigen::Vector3d(-1.25, -1e-9, 30.0), 2, ", ") == "-1.25, 0.00, 30.00");
  CHECK(fixed(Eigen::VectorXd(0), 2, ", ").empty());
}

TEST_CASE("A place is told in millimetres") {
  CHECK(place_mm({-1e-9, -0.1234567}) == "(0.000, -123.457) mm");
}

TEST_CASE("A time is told as roughly as it can be estimated") {
  CHECK(about_time(0.2) == "about 5 s");
  CHECK(about_time(40.1) == "about 45 s");
  CHECK(about_time(91.0) == "about 2 min");
  CHECK(about_time(720.0) == "about 12 min");
  CHECK(about_time(7900.0) == "about 2 h 10 min");
  CHECK(about_time(7300.0) == "about 2 h 00 min");
}

}  // namespace
}  // namespace planar
