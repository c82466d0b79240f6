#include "planar_servo/loop/vision/see_tool.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/units.h"
#include "vision/lamp_bench.h"

namespace planar {
namespace {

constexpr double kVision_m = 2e-5;  // a fiftieth of a pixel
constexpr double kDirection = 4.0 * kVision_m / test::kSeparation_m;

Frame frame_of(const TipPose& tip, double separation_m = test::kSeparation_m) {
  std::mt19937 random(1);
  return {test::picture_of(tip, random, separation_m), {{}, test::kSensor}, 1.0};
}

/// A map that predicts the same error everywhere, and is valid about the middle of the view.
ErrorMap constant_map(const Eigen::Vector2d& error) {
  IdwMap map;
  map.centers.resize(2, 3);
  map.centers << -0.1, 0.1, 0.0, -0.1, -0.1, 0.1;
  map.errors = error.replicate(1, 3);
  map.region.hull = {{-0.1, -0.1}, {0.1, -0.1}, {0.0, 0.1}};
  return map;
}

struct SeenTool {
  LampPair lamps;
  std::optional<ToolPlace> place;
};

SeenTool look_at(const VisionCalibration& vision, const Frame& frame,
                 const PairExpectation& expectation = {}) {
  LampTracker tracker(CenterMethod::kAuto);
  SeenTool seen{find_lamps(vision, tracker, frame, expectation), std::nullopt};
  if (const auto observation = observation_of(seen.lamps, frame.t_s))
    seen.place = see_tool(vision, *observation);
  return seen;
}

TEST_CASE("The tool is seen where it is and as it points") {
  const TipPose tip{{0.03, -0.02}, GENERATE(0.0, 90.0, -150.0) * kDegree};
  const VisionCalibration vision = test::vision_with(std::nullopt);
  const SeenTool seen = look_at(vision, frame_of(tip), expect_tool(vision, tip).value());
  REQUIRE(seen.lamps.status == LampStatus::kOk);
  REQUIRE(seen.place.has_value());
  CHECK((seen.place->tip().p - tip.p).norm() < kVision_m);
  CHECK(std::abs(wrap_angle(seen.place->tip().phi - tip.phi)) < kDirection);
  CHECK(seen.place->error.inside);
}

TEST_CASE("What the error map predicts is taken off, and its region is judged where vision sees") {
  const Eigen::Vector2d error(0.5e-3, -0.3e-3);
  const VisionCalibration vision = test::vision_with(constant_map(error));
  const TipPose within{{0.0, 0.0}, 0.0}, beyond{{0.0, 0.15}, 0.0};
  const auto place_at = [&](const TipPose& tip) {
    return look_at(vision, frame_of(tip), expect_tool(vision, tip).value()).place.value();
  };
  CHECK((place_at(within).tip().p - (within.p - error)).norm() < kVision_m);
  CHECK(place_at(within).error.inside);
  CHECK_FALSE(place_at(beyond).error.inside);
}

/// A field that shears what is seen, e_x = slope * y, about the whole view.
LampField shear(double slope) {
  LampField field;
  field.basis = basis_over_disc(0.3, 0.2);
  field.weights.setZero(field.basis.terms(), 2);
  field.weights(field.basis.centers.cols() + 2, 0) = slope * field.basis.radius;
  const Eigen::Index n = field.unknowns();
  field.factor.setZero(n, n);
  field.region.hull = {{-0.3, -0.3}, {0.3, -0.3}, {0.3, 0.3}, {-0.3, 0.3}};
  return field;
}

TEST_CASE("A field at the lamps takes the error off each, and turns the tool back") {
  const double slope = 4e-3;
  const TipPose seen{{0.02, 0.05}, 90.0 * kDegree};
  const VisionCalibration vision = test::vision_with(shear(slope));
  const ToolPlace place =
      look_at(vision, frame_of(seen), expect_tool(vision, seen).value()).place.value();
  CHECK((place.tip().p - Eigen::Vector2d(0.02 - slope * 0.05, 0.05)).norm() < kVision_m);
  CHECK(wrap_angle(place.tip().phi - seen.phi) == Approx(std::atan(slope)).margin(kDirection));
  CHECK(place.error.inside);
  const ErrorPrediction predicted = predict_error_at(vision, seen);
  CHECK((predicted.error - place.error.error).norm() < 1e-7);
  CHECK(predicted.inside);
}

TEST_CASE("Lamps at another distance than they were built to are no pair") {
  const TipPose tip{{0.0, 0.0}, 0.0};
  const VisionCalibration vision = test::vision_with(std::nullopt);
  const SeenTool seen = look_at(vision, frame_of(tip, 1.05 * test::kSeparation_m));
  CHECK(seen.lamps.status == LampStatus::kWrongDistance);
}

TEST_CASE("Equal lamps without a prediction have a place, but it is unknown which is which") {
  const TipPose tip{{0.02, 0.01}, 0.3};
  const VisionCalibration vision = test::vision_with(std::nullopt);
  const SeenTool seen = look_at(vision, frame_of(tip));
  CHECK(seen.lamps.status == LampStatus::kAmbiguous);
  REQUIRE(seen.place.has_value());
  CHECK((seen.place->tip().p - tip.p).norm() < kVision_m);
}

TEST_CASE("A frame without lamps has no tool") {
  const VisionCalibration vision = test::vision_with(std::nullopt);
  std::mt19937 random(1);
  const Frame dark{test::expose(test::background(test::kSensor), random), {{}, test::kSensor}, 1.0};
  const SeenTool seen = look_at(vision, dark);
  CHECK(seen.lamps.status == LampStatus::kNoLamp);
  CHECK_FALSE(seen.place.has_value());
}

}  // namespace
}  // namespace planar
