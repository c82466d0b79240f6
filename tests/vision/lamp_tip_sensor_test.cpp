#include "planar_servo/loop/vision/lamp_tip_sensor.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <utility>

#include "planar_servo/base/core/units.h"
#include "planar_servo/learn/error_map/fit_error_map.h"
#include "support/error_fields.h"
#include "vision/lamp_bench.h"

namespace planar {
namespace {

using test::kSensor;
using test::vision_with;
constexpr int kFollowRegion_px = 400;
const Eigen::Vector2d kBias(0.8e-3, -0.6e-3);  // of vision, in the tool's frame

/// Shows both lamps of a tool that stands at `tip`.
class TwoLamps final : public FrameSource {
 public:
  TipPose tip;
  int asked{0}, asked_on{0};
  std::vector<Eigen::Vector2d> fixed_px;  ///< where lamps are seen that are fixed to the base
  Eigen::Vector2d moved_px{0.0, 0.0};     ///< of everything that is seen
  double t_s{1.0}, period_s{0.0};         ///< of the next frame, and to the one after it
  int whole{0};                           ///< whole frames shown

  cv::Size sensor_size_px() const override { return kSensor; }
  void set_region(const cv::Rect& region_px) override { region_px_ = region_px; }
  FrameResult next_frame() override {
    ++asked;
    return show();
  }
  FrameResult following_frame() override {
    ++asked_on;
    return show();
  }
  std::optional<std::string> fault() const override { return std::nullopt; }
  FrameCounts counts() const override { return {}; }
  CameraExposure exposure() const override { return {}; }
  void set_exposure(const CameraExposure& /*exposure*/) override {}

 private:
  FrameResult show() {
    whole += region_px_.size() == kSensor ? 1 : 0;
    const auto lamps_px = lamps_from_tip(test::workplane_below(), {}, test::kSeparation_m, tip);
    cv::Mat scene = test::background(kSensor);
    for (const Eigen::Vector2d& uv_px : *lamps_px)
      test::add_lamp(scene, {uv_px + moved_px, test::kDiameter_m * test::kPixelsPerMetre});
    for (const Eigen::Vector2d& uv_px : fixed_px) test::add_lamp(scene, {uv_px + moved_px, 30.0});
    const double now_s = std::exchange(t_s, t_s + period_s);
    return {FrameStatus::kOk,
            {test::expose(scene, random_)(region_px_).clone(), region_px_, now_s}};
  }

  cv::Rect region_px_{{}, kSensor};
  std::mt19937 random_{1};
};

/// Learned from a vision that is off by kBias in the tool's frame, and else only noisy.
ErrorMap map_of_bias() {
  const auto nothing = [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); };
  auto samples = test::measure(nothing, test::random_positions(100, 1), test::kFieldNoise, 1);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].phi = 2.4 * static_cast<double>(i);
    samples[i].error += rotation2d(*samples[i].phi) * kBias;
  }
  return fit_error_map({samples}).map;
}

TEST_CASE("The end point is compensated for the direction in which the lamps show the tool") {
  const TipPose stands{{0.03, -0.02}, GENERATE(0.0, 90.0, -150.0) * kDegree};
  TwoLamps camera;
  camera.tip = stands;
  LampTipSensor sensor(vision_with(map_of_bias()), CenterMethod::kAuto, camera, kFollowRegion_px);
  const TipPose commanded{stands.p, stands.phi + 10.0 * kDegree};  // not what it is compensated for
  const TipMeasurement seen = sensor.measure(commanded, 1);
  REQUIRE(seen.ok());
  constexpr double kVision_m = 2e-5;  // a fiftieth of a pixel
  CHECK((seen.p_vision - stands.p).norm() < kVision_m);
  const Eigen::Vector2d bias = rotation2d(stands.phi) * kBias;
  CHECK((seen.correction - bias).norm() < test::kFieldNoise);
  CHECK((seen.tip.p - (stands.p - bias)).norm() < kVision_m + test::kFieldNoise);
}

/// A vision with four fixed lamps, and a camera that shows them.
VisionCalibration vision_with_fixed_lamps(TwoLamps& camera) {
  camera.fixed_px = {{40.0, 40.0}, {600.0, 45.0}, {45.0, 440.0}, {595.0, 435.0}};
  VisionCalibration vision = vision_with(std::nullopt);
  for (const Eigen::Vector2d& uv_px : camera.fixed_px)
    vision.reference_lamps.push_back(
        {"R" + std::to_string(vision.reference_lamps.size() + 1), uv_px, 0.005});
  return vision;
}

TEST_CASE("What the camera has moved since its calibration does not move the tool") {
  TwoLamps camera;
  camera.tip = {{0.03, -0.02}, 0.4};
  LampTipSensor sensor(vision_with_fixed_lamps(camera), CenterMethod::kAuto, camera,
                       kFollowRegion_px);
  const TipMeasurement before = sensor.measure(camera.tip, 3);
  camera.moved_px = {2.0, -1.5};
  camera.t_s += kReferencePeriod_s;
  const TipMeasurement after = sensor.measure(camera.tip, 3);
  REQUIRE((before.ok() && after.ok()));
  constexpr double kMoved_m = 2.5 / test::kPixelsPerMetre, kVision_m = 3e-5;
  CHECK((after.p_vision - before.p_vision).norm() < kVision_m);
  CHECK((after.lamps_px[0] - before.lamps_px[0]).norm() == Approx(2.5).margin(0.1));
  CHECK(kMoved_m > 10.0 * kVision_m);
  // It costs some certainty, which more frames do not bring back.
  CHECK(after.uncertainty_m > after.noise_m);
  CHECK(after.uncertainty_m < 3e-5);
}

TEST_CASE("A tool's lamp that is seen where a fixed lamp was before the camera moved is found") {
  TwoLamps camera;
  VisionCalibration vision = vision_with_fixed_lamps(camera);
  camera.fixed_px.emplace_back(430.0, 240.0);
  vision.reference_lamps.push_back({"R5", camera.fixed_px.back(), 0.005});
  LampTipSensor sensor(vision, CenterMethod::kAuto, camera, kFollowRegion_px);
  for (; camera.moved_px.x() <= 60.0; camera.moved_px.x() += 10.0) {  // lamp 2 was at (370, 240)
    CAPTURE(camera.moved_px.x());
    const TipMeasurement seen = sensor.measure(camera.tip, 1);
    CHECK(seen.ok());
    camera.t_s += kReferencePeriod_s;
  }
}

TEST_CASE("While a region follows the tool, a whole frame is looked at once a period") {
  TwoLamps camera;
  LampTipSensor sensor(vision_with_fixed_lamps(camera), CenterMethod::kAuto, camera,
                       kFollowRegion_px);
  for (int i = 0; i < 4; ++i) {
    CHECK(sensor.measure(camera.tip, 2).ok());
    camera.t_s += 0.4 * kReferencePeriod_s;
  }
  CHECK(camera.whole == 2);
}

TEST_CASE("Reference lamps that disagree end the measurement") {
  TwoLamps camera;
  LampTipSensor sensor(vision_with_fixed_lamps(camera), CenterMethod::kAuto, camera,
                       kFollowRegion_px);
  camera.fixed_px[0] += Eigen::Vector2d(3.0, 0.0);
  const TipMeasurement seen = sensor.measure(camera.tip, 1);
  CHECK(seen.status == TipStatus::kNoLamps);
  CHECK(seen.word == "reference_lamps");
}

TEST_CASE("Only the first frame of a measurement must be exposed after the question") {
  TwoLamps camera;
  LampTipSensor sensor(vision_with(std::nullopt), CenterMethod::kAuto, camera, kFollowRegion_px);
  camera.period_s = 0.1;
  const TipMeasurement seen = sensor.measure(camera.tip, 5);
  CHECK(seen.frames == 5);
  CHECK(seen.t_s == 1.0);  // all that it is made of is as new as the first
  CHECK(camera.asked == 1);
  CHECK(camera.asked_on == 4);
}

}  // namespace
}  // namespace planar
