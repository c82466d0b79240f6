#include "planar_servo/loop/health/health_record.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

/// Looks over a field: levels from 140 to 180, blur from 0.8 to 1.0 px, axes from 0.94 to 1.
std::vector<LampLooks> looks_of_field() {
  std::vector<LampLooks> looks;
  for (int i = 0; i <= 10; ++i) {
    const LampLook look{140.0 + 4.0 * i, 12.0, 0.8 + 0.02 * i, 1.0 - 0.006 * i};
    looks.push_back({look, look});
  }
  return looks;
}

std::optional<HealthFinding> found_with(void (*change)(LampLook&), double cost_m = 3e-5) {
  std::vector<LampLooks> now = looks_of_field();
  for (LampLooks& look : now) change(look[1]);
  return find_light_change(*ranges_of(looks_of_field()), now, cost_m);
}

}  // namespace

TEST_CASE("Light and focus as at the calibration are no finding, nor are single places of it") {
  const auto looks = looks_of_field();
  for (const LampLooks& look : looks)
    CHECK_FALSE(find_light_change(*ranges_of(looks), {look}, 1e-3));
  CHECK_FALSE(found_with([](LampLook& look) { look.level -= 60.0; }));
  CHECK_FALSE(find_light_change(*ranges_of(looks), {}, 1e-3));
  CHECK_FALSE(ranges_of({}));
}

TEST_CASE("A change of light or focus is named with its size, its lamp and what it was") {
  const auto light = found_with([](LampLook& look) {
    look.background = 90.0;
    look.level = 250.0;
  });
  REQUIRE(light);
  CHECK(light->what == HealthCause::kBackground);
  CHECK(light->cost_m == 3e-5);
  CHECK_THAT(light->fault, Catch::Contains("background of lamp 2 is 90 of 255, was 12 to 12"));
  const auto bright = found_with([](LampLook& look) { look.level = 255.0; });
  REQUIRE(bright);
  CHECK(bright->what == HealthCause::kTooBright);
  const auto unclear = found_with([](LampLook& look) { look.blur_px = 2.0; });
  REQUIRE(unclear);
  CHECK(unclear->what == HealthCause::kUnclearLamp);  // one of two: the lens has kept its focus
  std::vector<LampLooks> unfocused = looks_of_field();
  for (LampLooks& look : unfocused) look[0].blur_px = look[1].blur_px = 2.0;
  const auto blurred = find_light_change(*ranges_of(looks_of_field()), unfocused, 3e-5);
  REQUIRE(blurred);
  CHECK(blurred->what == HealthCause::kBlurred);
  CHECK_THAT(blurred->fault, Catch::Contains("blurred by 2.00 px, was 0.80 to 1.00"));
  const auto oval = found_with([](LampLook& look) { look.axis_ratio = 0.7; });
  REQUIRE(oval);
  CHECK(oval->what == HealthCause::kOval);
}

}  // namespace planar
