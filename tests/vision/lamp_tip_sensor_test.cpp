#include "planar_servo/vision/lamp_tip_sensor.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/core/units.h"
#include "planar_servo/error_map/fit_error_map.h"
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
    return {FrameStatus::kOk,
            {test::picture_of(tip, random_)(region_px_).clone(), region_px_, 1.0}};
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

TEST_CASE("Only the first frame of a measurement must be exposed after the question") {
  TwoLamps camera;
  LampTipSensor sensor(vision_with(std::nullopt), CenterMethod::kAuto, camera, kFollowRegion_px);
  const TipMeasurement seen = sensor.measure(camera.tip, 5);
  CHECK(seen.frames == 5);
  CHECK(camera.asked == 1);
  CHECK(camera.asked_on == 4);
}

}  // namespace
}  // namespace planar
