#include "planar_servo/virtual_cell/image/virtual_camera.h"

#include <algorithm>
#include <cmath>

namespace planar {

VirtualCamera::VirtualCamera(const Truth& truth, const VirtualHardware& hardware,
                             const VirtualLens& lens, VirtualArm& arm, const VirtualBoard& board,
                             VirtualClock& clock)
    : sensor_px_(hardware.sensor_px),
      frame_rate_hz_(hardware.frame_rate_hz),
      seed_(truth.seed),
      lens_(lens),
      arm_(arm),
      board_(board),
      clock_(clock),
      lamps_(truth),
      noise_(truth.noise, truth.seed),
      region_px_(cv::Point(), hardware.sensor_px) {}

void VirtualCamera::set_region(const cv::Rect& region_px) {
  require_region(region_px, sensor_px_);
  region_px_ = region_px;
}

void VirtualCamera::set_exposure(const CameraExposure& exposure) {
  require_exposure(exposure);
  exposure_ = exposure;
}

FrameResult VirtualCamera::next_frame() {
  const auto periods = static_cast<std::uint64_t>(std::ceil(clock_.now_s() * frame_rate_hz_));
  const std::uint64_t exposure = std::max(periods, next_exposure_);
  next_exposure_ = exposure + 1;
  const double t_s = static_cast<double>(exposure) / frame_rate_hz_;
  clock_.advance_to(std::max(t_s, clock_.now_s()));

  ++taken_;
  const double brightness =
      exposure_.time_s / kUsualTime_s * std::pow(10.0, exposure_.gain_db / 20.0);
  const cv::Mat image =
      arm_.moves() ? expose_moving(brightness, exposure) : expose(region_px_, brightness, exposure);
  return {FrameStatus::kOk, {image, region_px_, t_s, exposure}};
}

cv::Mat VirtualCamera::expose_moving(double brightness, std::uint64_t exposure) {
  const double begin_s = clock_.now_s();
  cv::Mat1f levels(region_px_.size(), 0.0F);
  for (int i = 0; i < kMomentsOfExposure; ++i) {
    clock_.advance_to(begin_s + (i + 0.5) / kMomentsOfExposure * exposure_.time_s);
    for (const Light& seen : lights(clock_.now_s())) {
      const cv::Rect lit_px = seen.window_px & region_px_;
      if (lit_px.empty()) continue;
      cv::Mat1f sum = levels(lit_px - region_px_.tl());
      cv::scaleAdd(seen.levels(lit_px - seen.window_px.tl()), brightness / kMomentsOfExposure, sum,
                   sum);
    }
  }
  clock_.advance_to(begin_s + exposure_.time_s);
  cv::Mat image(region_px_.size(), CV_8UC1);
  Random random(seed_, RandomStream::kFrame, exposure);
  noise_.expose(levels, image, random);
  return image;
}

cv::Mat VirtualCamera::expose(const cv::Rect& region_px, double brightness,
                              std::uint64_t exposure) {
  require_region(region_px, sensor_px_);
  cv::Mat image(region_px.size(), CV_8UC1);
  Random random(seed_, RandomStream::kFrame, exposure);
  noise_.fill_dark(image, random);
  for (const Light& seen : lights(clock_.now_s())) {
    const cv::Rect lit_px = seen.window_px & region_px;
    if (lit_px.empty()) continue;
    cv::Mat1f levels;
    seen.levels(lit_px - seen.window_px.tl()).convertTo(levels, CV_32F, brightness);
    noise_.expose(levels, image(lit_px - region_px.tl()), random);
  }
  return image;
}

std::vector<Light> VirtualCamera::lights(double t_s) {
  if (!board_.X_BG()) return lamps_.render_all(arm_.X_BT(), lens_, t_s);
  const std::optional<Light> board = board_.render(t_s);
  return board ? std::vector<Light>{*board} : std::vector<Light>();
}

}  // namespace planar
