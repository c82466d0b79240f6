#include "planar_servo/learn/error_map/error_map.h"

#include <catch2/catch.hpp>

#include "planar_servo/learn/error_map/fit_error_map.h"
#include "support/error_fields.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

TEST_CASE("Components within 1.96 deviations are counted each by its own") {
  CHECK(components_within_95({0.0, 0.0}, {1.0, 1.0}) == 2);
  CHECK(components_within_95({1.95, -1.97}, {1.0, 1.0}) == 1);
  CHECK(components_within_95({1.95, -1.97}, {0.9, 1.1}) == 1);
  CHECK(components_within_95({-5.0, 5.0}, {1.0, 1.0}) == 0);
}

TEST_CASE("A map speaks against itself when it is useless or states far too little") {
  CHECK_FALSE(objection({200, true, 0.95}));
  CHECK_FALSE(objection({200, true, 0.75}));  // chance makes 80 % so
  CHECK_FALSE(objection({12, true, 0.6}));
  CHECK_THAT(InputError(objection({200, true, 0.7}).value()),
             Refused(Cause::kContradiction, "70 % of what 200 places"));
  CHECK(objection({200, false, 0.95}).value().cause == Cause::kInsufficient);
}

TEST_CASE("A map that nothing judges is not spoken against") {
  CHECK_FALSE(objection({0, false, 0.0}));
}

TEST_CASE("Every kind of map says how many places left out lie within its stated 95 %") {
  const auto samples_at = [](int count) {
    return test::measure(test::glow_field, test::random_positions(count, 1), test::kFieldNoise, 1);
  };
  CHECK(fit_error_map({samples_at(200)}).coverage_95 == Approx(0.95).margin(0.04));
  CHECK(fit_error_map({samples_at(200), MapMethod::kRbf}).coverage_95 == Approx(0.95).margin(0.04));
  CHECK(fit_error_map({samples_at(1200)}).coverage_95 == Approx(0.95).margin(0.02));
  CHECK(fit_error_map({samples_at(200), MapMethod::kIdw}).coverage_95 == Approx(0.95).margin(0.05));
}

}  // namespace
}  // namespace planar
