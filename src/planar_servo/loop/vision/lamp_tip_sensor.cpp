#include "planar_servo/loop/vision/lamp_tip_sensor.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr char kOutsideView[] = "outside_view";

/// Logs one line for every look, for -v.
void log(const TipMeasurement& seen, const TipPose& expected) {
  if (!spdlog::should_log(spdlog::level::debug)) return;
  if (!seen.ok()) {
    spdlog::debug(fmt::format("look at {}: {}", place_mm(expected.p), seen.word));
    return;
  }
  const auto& [first, second] = seen.lamps_px;
  spdlog::debug(fmt::format(
      "look at {}: {} frames, lamps ({}) and ({}) px, seen at {}, {} by the error map{}, +- {:.4f} "
      "mm",
      place_mm(expected.p), seen.frames, fixed(first, 3, ", "), fixed(second, 3, ", "),
      place_mm(seen.p_vision), place_mm(-seen.correction),
      seen.inside_map ? "" : " outside its region", mm(seen.uncertainty_m)));
}

}  // namespace

cv::Rect follow_region(const cv::Size& sensor_px, int side_px, const Eigen::Vector2d& center_px) {
  const int width = std::min(side_px, sensor_px.width);
  const int height = std::min(side_px, sensor_px.height);
  const auto start = [](double center, int size, int sensor) {
    const double wanted = std::clamp(center - size / 2.0, 0.0, static_cast<double>(sensor - size));
    return static_cast<int>(std::lround(wanted));
  };
  return {start(center_px.x(), width, sensor_px.width),
          start(center_px.y(), height, sensor_px.height), width, height};
}

LampTipSensor::LampTipSensor(VisionCalibration vision, CenterMethod method, FrameSource& camera,
                             int follow_region_px)
    : vision_(std::move(vision)),
      tracker_(method),
      watch_(vision_.reference_lamps, method),
      camera_(camera),
      follow_region_px_(follow_region_px) {}

void LampTipSensor::aim(const TipPose& expected) {
  if (const auto predicted = lamps_at(expected)) aim_at(*predicted);
}

void LampTipSensor::aim_at(const LampPixels& lamps_px) {
  camera_.set_region(follow_region(camera_.sensor_size_px(), follow_region_px_,
                                   0.5 * (lamps_px[0] + lamps_px[1])));
}

std::optional<LampPixels> LampTipSensor::lamps_at(const TipPose& tip) const {
  auto lamps_px = lamps_from_tip(vision_.workplane, vision_.tool, vision_.lamps.separation_m, tip);
  if (!lamps_px) return std::nullopt;
  for (Eigen::Vector2d& uv_px : *lamps_px) uv_px = watch_.motion().now(uv_px);
  return lamps_px;
}

TipMeasurement LampTipSensor::measure(const TipPose& expected, int frames) {
  TipMeasurement measurement = look_at_tool(expected, frames);
  log(measurement, expected);
  return measurement;
}

TipMeasurement LampTipSensor::look_at_tool(const TipPose& expected, int frames) {
  auto expectation = expect_tool(vision_, expected);
  if (!expectation) return failed_look(TipStatus::kOutsideView, kOutsideView, 0.0);
  for (Eigen::Vector2d& uv_px : *expectation->predicted_px) uv_px = watch_.motion().now(uv_px);
  for (Eigen::Vector2d& uv_px : expectation->fixed_px) uv_px = watch_.motion().now(uv_px);
  aim_at(*expectation->predicted_px);
  std::vector<Observation> observations;
  for (int i = 0; i < frames; ++i) {
    const Look seen = look(i == 0 ? camera_.next_frame() : camera_.following_frame(), *expectation);
    if (seen.frame != FrameStatus::kOk)
      return failed_look(TipStatus::kNoPicture, name(seen.frame), seen.t_s);
    if (!seen.found()) return failed_look(TipStatus::kNoLamps, name(seen.pair.status), seen.t_s);
    observations.push_back(observation_of(seen.pair, seen.t_s).value());
  }
  if (auto failed = watch_camera(observations.back().t_s)) return *failed;
  return position(mean_of(observations));
}

std::optional<std::array<Eigen::Vector2d, 2>> LampTipSensor::look_around() {
  camera_.set_region({{}, camera_.sensor_size_px()});
  FrameResult result = camera_.next_frame();
  if (result.status != FrameStatus::kOk) return std::nullopt;
  last_frame_ = std::move(result.frame);
  Frame without_fixed = last_frame_;
  without_fixed.image = watch_.without_lamps(last_frame_.image);
  PairExpectation anywhere;
  anywhere.diameter_over_separation = vision_.lamps.diameter_over_separation();
  const LampPair pair = tracker_.locate(without_fixed, anywhere);
  last_looks_ = {pair.lamps[0].look, pair.lamps[1].look};
  for (const LampCenter& lamp : pair.lamps)  // of several pairs each lamp is ambiguous
    if (lamp.status != LampStatus::kOk) return std::nullopt;
  std::array<Eigen::Vector2d, 2> lamps_B;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto p_W = vision_.workplane.plane_from_pixel(watch_.motion().then(pair.lamps[k].uv_px));
    if (!p_W) return std::nullopt;
    lamps_B[k] = *p_W;
  }
  return lamps_B;
}

std::optional<TipMeasurement> LampTipSensor::watch_camera(double t_s) {
  if (!watch_.is_due(t_s)) return std::nullopt;
  camera_.set_region({{}, camera_.sensor_size_px()});
  const FrameResult whole = camera_.next_frame();
  if (whole.status != FrameStatus::kOk)
    return failed_look(TipStatus::kNoPicture, name(whole.status), whole.frame.t_s);
  watch_.look(whole.frame);
  if (!watch_.objection()) return std::nullopt;
  spdlog::warn(watch_.objection()->text());
  return failed_look(TipStatus::kNoLamps, "reference_lamps", whole.frame.t_s);
}

LampTipSensor::Look LampTipSensor::locate(const FrameResult& result,
                                          const PairExpectation& expectation) {
  if (result.status != FrameStatus::kOk) return {{}, result.frame.t_s, result.status};
  last_frame_ = result.frame;
  if (last_frame_.region_px.size() == camera_.sensor_size_px()) watch_.look(last_frame_);
  const LampPair pair = find_lamps(vision_, tracker_, last_frame_, expectation);
  last_looks_ = {pair.lamps[0].look, pair.lamps[1].look};
  return {pair, last_frame_.t_s, FrameStatus::kOk};
}

LampTipSensor::Look LampTipSensor::look(const FrameResult& result,
                                        const PairExpectation& expectation) {
  Look seen = locate(result, expectation);
  const cv::Size sensor_px = camera_.sensor_size_px();
  if (seen.frame != FrameStatus::kOk || seen.found() || last_frame_.region_px.size() == sensor_px)
    return seen;
  camera_.set_region({{}, sensor_px});
  seen = locate(camera_.next_frame(), expectation);
  if (seen.found()) aim_at({seen.pair.lamps[0].uv_px, seen.pair.lamps[1].uv_px});
  return seen;
}

TipMeasurement LampTipSensor::position(const Observation& seen) const {
  const auto place = see_tool(vision_, at_calibration(seen, watch_.motion()));
  if (!place) return failed_look(TipStatus::kOutsideView, kOutsideView, seen.t_s);
  TipMeasurement measurement;
  measurement.t_s = seen.t_s;
  measurement.frames = seen.frames;
  measurement.lamps_px = seen.lamps_px;
  measurement.lamps_B = place->seen.lamps_B;
  measurement.p_vision = place->seen.tip.p;
  measurement.correction = place->error.error;
  measurement.tip = place->tip();
  measurement.inside_map = place->error.inside;
  measurement.turn_sigma = place->seen.sigma_phi;
  measurement.noise_m = per_axis(place->seen.noise);
  measurement.uncertainty_m = std::hypot(place->error.sigma, per_axis(place->seen.covariance));
  return measurement;
}

}  // namespace planar
