#include "planar_servo/loop/servo/motion_guard.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

TransmissionSettings wide_limits() {
  TransmissionSettings settings;
  for (auto& limits : settings.limits_rad) limits = {-20.0, 20.0};
  return settings;
}

}  // namespace

TEST_CASE("An approach from one side must not lead through a keep-out disc beside its end") {
  const PlanarArm arm({{0.3, 0.3}, Rotation::kCounterclockwise});
  const Transmission transmission{wide_limits()};
  const Joints end(0.5, 2.0, 0.0), from(0.9, 2.4, 0.0);
  ServoSettings settings;
  const Eigen::Vector2d short_of =
      arm.forward(approach_stops(transmission, settings, end).front()).p;
  const double way = (short_of - arm.forward(end).p).norm();
  const JointPlanner planner(arm, transmission, {0.06, 0.54, {{short_of, 0.5 * way}}},
                             Elbow::kLeft);
  CHECK_THAT(*approach_refusal(planner, settings, from, end),
             Catch::Contains("on the approach from one side, the way there leads") &&
                 Catch::Contains("into the keep-out disc"));
  settings.approach = Approach::kDirect;
  CHECK(approach_stops(transmission, settings, end) == std::vector<Joints>{end});
  CHECK_FALSE(approach_refusal(planner, settings, from, end));
  CHECK(approach_refusal(planner, settings, Joints(0.1, 1.6, 0.0), end));
}

}  // namespace planar
