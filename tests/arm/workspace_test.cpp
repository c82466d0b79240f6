#include "planar_servo/geometry/arm/planar_arm.h"

#include <catch2/catch.hpp>
#include <limits>

namespace planar {
namespace {

TEST_CASE("The workspace is a ring without its keep-out discs, and says what forbids a point") {
  const Workspace workspace{0.06, 0.54, {{{0.3, 0.0}, 0.05}}};
  CHECK_FALSE(workspace.violation({0.0, 0.3}));
  CHECK_FALSE(workspace.violation({0.3, 0.051}));
  CHECK_THAT(*workspace.violation({0.0, 0.05}), Catch::Contains("50.000 mm from the base") &&
                                                    Catch::Contains("from 60.000 to 540.000 mm"));
  CHECK_THAT(*workspace.violation({-0.6, 0.0}), Catch::Contains("600.000 mm from the base"));
  CHECK_THAT(*workspace.violation({0.3, 0.049}), Catch::Contains("keep-out disc of 50.000 mm"));
  CHECK(workspace.violation({std::numeric_limits<double>::quiet_NaN(), 0.3}));
  CHECK(workspace.excess_m({0.0, 0.3}) == 0.0);
  CHECK(workspace.excess_m({0.0, 0.05}) == Approx(0.01));
  CHECK(workspace.excess_m({-0.6, 0.0}) == Approx(0.06));
  CHECK(workspace.excess_m({0.3, 0.049}) == Approx(0.001));
}

}  // namespace
}  // namespace planar
