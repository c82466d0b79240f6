#include "planar_servo/loop/vision/reference_lamps.h"

#include <catch2/catch.hpp>

#include "support/refused.h"
#include "vision/lamp_bench.h"

namespace planar {
namespace {

using test::kSensor;
using test::Refused;
constexpr double kSeen_px = 0.06;  // several times the error of a centre
const Eigen::Vector2d kShift(1.3, -0.8);

const std::vector<Eigen::Vector2d>& stands() {
  static const std::vector<Eigen::Vector2d> places{{60.0, 70.0},  {320.0, 60.0},  {580.0, 75.0},
                                                   {70.0, 410.0}, {330.0, 420.0}, {575.0, 400.0}};
  return places;
}

std::vector<ReferenceLamp> lamps() {
  std::vector<ReferenceLamp> lamps;
  for (const Eigen::Vector2d& place : stands())
    lamps.push_back({"R" + std::to_string(lamps.size() + 1), place, 0.005});
  return lamps;
}

/// A whole frame with fixed lamps, all but those that are covered.
Frame frame_with(std::vector<Eigen::Vector2d> places, std::size_t covered = 0, double t_s = 0.0) {
  static std::mt19937 random(5);
  places.erase(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(covered));
  cv::Mat scene = test::background(kSensor);
  for (const Eigen::Vector2d& place : places) test::add_lamp(scene, {place, 30.0});
  return {test::expose(scene, random), {{}, kSensor}, t_s};
}

std::vector<Eigen::Vector2d> shifted(const Eigen::Vector2d& shift) {
  std::vector<Eigen::Vector2d> places = stands();
  for (Eigen::Vector2d& place : places) place += shift;
  return places;
}

TEST_CASE("Fixed lamps tell how the camera's image has moved") {
  ReferenceWatch watch(lamps(), CenterMethod::kAuto);
  watch.look(frame_with(shifted(kShift)));
  CHECK_FALSE(watch.objection());
  const Eigen::Vector2d place(300.0, 200.0);
  CHECK((watch.motion().then(place + kShift) - place).norm() < kSeen_px);
  const Eigen::Matrix2d covariance = watch.motion().covariance_px2(place);
  CHECK(covariance.trace() > 0.0);
  CHECK(std::sqrt(covariance.trace()) < 0.02);
}

TEST_CASE("A camera that keeps moving is followed further than a window reaches") {
  ReferenceWatch watch(lamps(), CenterMethod::kAuto);
  for (const double part : {1.0, 2.0, 3.0})
    watch.look(frame_with(shifted(part * Eigen::Vector2d(-10.0, 0.0))));
  CHECK_FALSE(watch.objection());
  CHECK((watch.motion().now({320.0, 240.0}) - Eigen::Vector2d(290.0, 240.0)).norm() < kSeen_px);
}

TEST_CASE("A covered lamp does not matter, and too few lamps are said to be too few") {
  ReferenceWatch watch(lamps(), CenterMethod::kAuto);
  watch.look(frame_with(shifted(kShift), 2));
  CHECK_FALSE(watch.objection());
  CHECK((watch.motion().then(stands()[4] + kShift) - stands()[4]).norm() < kSeen_px);
  watch.look(frame_with(shifted(kShift), 4));
  REQUIRE(watch.objection());
  CHECK_THAT(InputError(*watch.objection()), Refused(Cause::kInsufficient, "2 of 6"));
  watch.look(frame_with(shifted(kShift)));
  CHECK_FALSE(watch.objection());
}

TEST_CASE("One knocked lamp is left out, and the others show the motion") {
  ReferenceWatch watch(lamps(), CenterMethod::kAuto);
  auto places = shifted(kShift);
  places[1] += Eigen::Vector2d(0.0, 2.0);
  watch.look(frame_with(places));
  CHECK_FALSE(watch.objection());
  CHECK((watch.motion().then(stands()[4] + kShift) - stands()[4]).norm() < kSeen_px);
}

TEST_CASE("Lamps that disagree make the calibration void") {
  ReferenceWatch watch(lamps(), CenterMethod::kAuto);
  auto places = stands();
  places[0] += Eigen::Vector2d(2.0, 0.0);
  places[3] += Eigen::Vector2d(0.0, 2.0);
  places[5] += Eigen::Vector2d(-2.0, 1.0);
  watch.look(frame_with(places));
  REQUIRE(watch.objection());
  CHECK(watch.objection()->cause == Cause::kContradiction);
  CHECK(watch.is_due(0.0));
}

TEST_CASE("A look is due at first and then every period, and never without lamps") {
  ReferenceWatch watch(lamps(), CenterMethod::kAuto);
  CHECK(watch.is_due(100.0));
  watch.look(frame_with(stands(), 0, 100.0));
  CHECK_FALSE(watch.is_due(100.0 + 0.99 * kReferencePeriod_s));
  CHECK(watch.is_due(100.0 + kReferencePeriod_s));
  ReferenceWatch none({}, CenterMethod::kAuto);
  none.look(frame_with(stands()));
  CHECK_FALSE(none.is_due(1e6));
  CHECK(none.motion().then({3.0, 4.0}) == Eigen::Vector2d(3.0, 4.0));
}

}  // namespace
}  // namespace planar
