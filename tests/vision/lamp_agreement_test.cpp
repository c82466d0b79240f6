#include "planar_servo/loop/vision/found_landings.h"

#include <catch2/catch.hpp>
#include <random>

namespace planar {
namespace {

TEST_CASE("Lamps that stand to each other as at other targets agree, within what these scatter") {
  LampAgreement lamps;
  CHECK_FALSE(lamps.agrees(40e-3, 0.0));  // nobody knows
  std::mt19937 random(5);
  std::normal_distribution<double> apart_m(40e-3, 3e-6), turn(1e-3, 80e-6);
  for (int i = 0; i < 100; ++i) lamps.take(apart_m(random), turn(random));
  CHECK(lamps.knows());
  for (int i = 0; i < 1000; ++i) CHECK(lamps.agrees(apart_m(random), turn(random)));
  CHECK_FALSE(lamps.agrees(40e-3 + 40e-6, 1e-3));
  CHECK_FALSE(lamps.agrees(40e-3 - 40e-6, 1e-3));
  CHECK_FALSE(lamps.agrees(40e-3, 2.2e-3));
}

TEST_CASE("The lamps' recent distance counts, not one of long ago") {
  LampAgreement lamps;
  for (int i = 0; i < 100; ++i) lamps.take(40e-3, 0.0);
  for (int i = 0; i < 40; ++i) lamps.take(40.1e-3, 0.0);
  CHECK(lamps.agrees(40.1e-3, 0.0));
  CHECK_FALSE(lamps.agrees(40e-3, 0.0));
}

}  // namespace
}  // namespace planar
