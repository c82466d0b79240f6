#include "planar_servo/lamps/lamp_tracker.h"

#include <catch2/catch.hpp>

#include "support/rendered_lamp.h"

namespace planar {
namespace {

constexpr double kMeasured_px = 0.12;  // four times the clean lamp's error of 0.03 px
const Eigen::Vector2d kFirst(200.4, 220.3), kSecond(390.8, 240.6);
const Eigen::Vector2d kOrigin(3000, 1200);

Frame frame_with(const std::vector<Eigen::Vector2d>& lamps) {
  std::mt19937 random(30);
  cv::Mat scene = test::background({600, 500});
  for (const Eigen::Vector2d& center : lamps) test::add_lamp(scene, {center});
  Frame frame;
  frame.image = test::expose(scene, random);
  frame.region_px = {3000, 1200, 600, 500};
  return frame;
}

PairExpectation expectation(double error_px) {
  PairExpectation result;
  result.predicted_px = {kOrigin + kFirst + Eigen::Vector2d(error_px, 0.0),
                         kOrigin + kSecond + Eigen::Vector2d(error_px, 0.0)};
  result.separation_px = {180.0, 205.0};
  return result;
}

TEST_CASE("Lights that are known to be fixed are no lamps, wherever the pair is sought") {
  const Eigen::Vector2d fixed_a(300.0, 80.0), fixed_b(430.0, 90.0);
  const Frame frame = frame_with({fixed_a, fixed_b, kFirst, kSecond});
  LampTracker tracker(CenterMethod::kAuto);
  PairExpectation nothing_predicted;
  CHECK(tracker.locate(frame, nothing_predicted).lamps[0].status == LampStatus::kAmbiguous);
  nothing_predicted.fixed_px = {kOrigin + fixed_a + Eigen::Vector2d(5.0, 0.0), kOrigin + fixed_b};
  const LampPair pair = tracker.locate(frame, nothing_predicted);
  REQUIRE(pair.status == LampStatus::kAmbiguous);
  const auto found = [&](const Eigen::Vector2d& lamp) {
    return (pair.lamps[0].uv_px - kOrigin - lamp).norm() < kMeasured_px ||
           (pair.lamps[1].uv_px - kOrigin - lamp).norm() < kMeasured_px;
  };
  CHECK(found(kFirst));
  CHECK(found(kSecond));
}

TEST_CASE("LampTracker measures both lamps in sensor pixels under a good and a poor prediction") {
  const Frame frame = frame_with({kFirst, kSecond});
  for (const auto method : {CenterMethod::kAuto, CenterMethod::kCannyKasa, CenterMethod::kVpDot2}) {
    LampTracker tracker(method);
    for (const double error : {0.0, 12.0, 60.0}) {
      const LampPair pair = tracker.locate(frame, expectation(error));
      REQUIRE(pair.status == LampStatus::kOk);
      CHECK((pair.lamps[0].uv_px - kOrigin - kFirst).norm() < kMeasured_px);
      CHECK((pair.lamps[1].uv_px - kOrigin - kSecond).norm() < kMeasured_px);
    }
  }
}

TEST_CASE("LampTracker names the lamps by the prediction, not by their place in the image") {
  PairExpectation swapped = expectation(0.0);
  std::swap((*swapped.predicted_px)[0], (*swapped.predicted_px)[1]);
  const LampPair pair =
      LampTracker(CenterMethod::kAuto).locate(frame_with({kFirst, kSecond}), swapped);
  REQUIRE(pair.status == LampStatus::kOk);
  CHECK((pair.lamps[0].uv_px - kOrigin - kSecond).norm() < kMeasured_px);
}

TEST_CASE("LampTracker answers the same whatever it has seen before") {
  LampTracker used(CenterMethod::kAuto);
  used.locate(frame_with({kSecond, {100, 400}}), {});
  used.locate(frame_with({}), expectation(0.0));
  const Frame frame = frame_with({kFirst, kSecond});
  for (const double error : {0.0, 60.0}) {
    const LampPair a = used.locate(frame, expectation(error));
    const LampPair b = LampTracker(CenterMethod::kAuto).locate(frame, expectation(error));
    for (const std::size_t i : {0u, 1u}) {
      CHECK(a.lamps[i].uv_px == b.lamps[i].uv_px);
      CHECK(a.lamps[i].covariance_px2 == b.lamps[i].covariance_px2);
    }
  }
}

TEST_CASE("LampTracker says why there is no pair") {
  LampTracker tracker(CenterMethod::kAuto);
  const auto status = [&](const std::vector<Eigen::Vector2d>& lamps) {
    return tracker.locate(frame_with(lamps), expectation(0.0)).status;
  };
  CHECK(status({}) == LampStatus::kNoLamp);
  CHECK(status({kFirst}) == LampStatus::kOneLamp);
  CHECK(status({kFirst, {300, 400}}) == LampStatus::kWrongDistance);
  CHECK(status({{8, 240}, {200, 240}}) == LampStatus::kAtBorder);
  CHECK(tracker.locate({}, {}).status == LampStatus::kNoLamp);
  CHECK(tracker.locate({cv::Mat(4, 4, CV_8UC1, cv::Scalar(9)), {0, 0, 4, 4}}, {}).status ==
        LampStatus::kNoLamp);
}

TEST_CASE("LampTracker measures an unnamed pair, and says so") {
  const LampPair pair = LampTracker(CenterMethod::kAuto).locate(frame_with({kFirst, kSecond}), {});
  CHECK(pair.status == LampStatus::kAmbiguous);
  for (const LampCenter& lamp : pair.lamps) {
    CHECK(lamp.status == LampStatus::kOk);
    const Eigen::Vector2d local = lamp.uv_px - kOrigin;
    CHECK(std::min((local - kFirst).norm(), (local - kSecond).norm()) < kMeasured_px);
  }
}

TEST_CASE("LampTracker is not misled by a third light while a lamp is hidden") {
  const Eigen::Vector2d third(420, 420);  // 298 px from the first lamp
  const LampPair pair =
      LampTracker(CenterMethod::kAuto).locate(frame_with({kFirst, third}), expectation(0.0));
  CHECK(pair.status == LampStatus::kWrongDistance);
}

/// A frame of a region of the sensor with this corner, lamps given in pixels of the sensor.
Frame region_with(const cv::Point& corner, const std::vector<Eigen::Vector2d>& lamps) {
  std::vector<Eigen::Vector2d> local;
  for (const Eigen::Vector2d& uv : lamps) local.push_back(uv - Eigen::Vector2d(corner.x, corner.y));
  Frame frame = frame_with(local);
  frame.region_px = {corner.x, corner.y, 600, 500};
  return frame;
}

PairExpectation right_distance() {
  PairExpectation result;
  result.separation_px = {180.0, 205.0};
  return result;
}

TEST_CASE("LampTracker follows the lamps by vpDot2 while they and the region move") {
  LampTracker tracker(CenterMethod::kVpDot2);
  Eigen::Vector2d first = kOrigin + kFirst, second = kOrigin + kSecond;
  cv::Point corner(3000, 1200);
  PairExpectation expected = expectation(0.0);
  for (int i = 0; i < 6; ++i) {
    const LampPair pair = tracker.locate(region_with(corner, {first, second}), expected);
    REQUIRE(pair.status == LampStatus::kOk);
    CHECK((pair.lamps[0].uv_px - first).norm() < kMeasured_px);
    CHECK((pair.lamps[1].uv_px - second).norm() < kMeasured_px);
    const Eigen::Vector2d step(11.3, -6.7);
    first += step;
    second += step;
    for (Eigen::Vector2d& uv : *expected.predicted_px) uv += step;
    corner += cv::Point(37, -29);
  }
}

TEST_CASE("LampTracker by vpDot2 keeps to its lamps when others of the same distance appear") {
  const std::vector<Eigen::Vector2d> with_others{kFirst, kSecond, {205.0, 420.0}, {396.0, 430.0}};
  LampTracker tracker(CenterMethod::kVpDot2);
  REQUIRE(tracker.locate(frame_with({kFirst, kSecond}), expectation(0.0)).status ==
          LampStatus::kOk);
  const LampPair pair = tracker.locate(frame_with(with_others), right_distance());
  for (const LampCenter& lamp : pair.lamps) {
    CHECK(lamp.status == LampStatus::kOk);
    CHECK(lamp.uv_px.y() - kOrigin.y() < 300.0);
  }
  tracker.forget();
  const LampPair afresh = tracker.locate(frame_with(with_others), right_distance());
  CHECK(afresh.lamps[0].status == LampStatus::kAmbiguous);
}

TEST_CASE("LampTracker by vpDot2 begins anew after a loss, a jump and a lamp that is hidden") {
  LampTracker tracker(CenterMethod::kVpDot2);
  const auto status = [&](const std::vector<Eigen::Vector2d>& lamps) {
    return tracker.locate(frame_with(lamps), right_distance());
  };
  const auto measured = [&](const Eigen::Vector2d& first, const Eigen::Vector2d& second) {
    const LampPair pair = status({first, second});
    double worst = 0.0;
    for (const LampCenter& lamp : pair.lamps) {
      const Eigen::Vector2d local = lamp.uv_px - kOrigin;
      worst = std::max(worst, std::min((local - first).norm(), (local - second).norm()));
    }
    return worst;
  };
  CHECK(measured(kFirst, kSecond) < kMeasured_px);
  CHECK(status({}).status == LampStatus::kNoLamp);
  CHECK(measured(kFirst, kSecond) < kMeasured_px);
  const Eigen::Vector2d jump(180.0, 150.0);  // lamp 1 comes near to where lamp 2 was
  CHECK(measured(kFirst + jump, kSecond + jump) < kMeasured_px);
  CHECK(status({kFirst + jump}).status == LampStatus::kOneLamp);
  CHECK(measured(kFirst + jump, kSecond + jump) < kMeasured_px);
}

TEST_CASE("LampTracker by vpDot2 answers as if new once it has forgotten its lamps") {
  LampTracker used(CenterMethod::kVpDot2);
  used.locate(frame_with({kFirst + Eigen::Vector2d(3, 2), kSecond}), expectation(0.0));
  used.forget();
  const Frame frame = frame_with({kFirst, kSecond});
  const LampPair a = used.locate(frame, expectation(0.0));
  const LampPair b = LampTracker(CenterMethod::kVpDot2).locate(frame, expectation(0.0));
  for (const std::size_t i : {0u, 1u}) CHECK(a.lamps[i].uv_px == b.lamps[i].uv_px);
}

}  // namespace
}  // namespace planar
