#include "virtual_cell/virtual_camera.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

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
  if (region_px.empty() || (region_px & cv::Rect(cv::Point(), sensor_px_)) != region_px)
    throw std::invalid_argument("a camera's region must not be empty or leave the sensor");
  region_px_ = region_px;
}

FrameResult VirtualCamera::next_frame() {
  const auto periods = static_cast<std::uint64_t>(std::ceil(clock_.now_s() * frame_rate_hz_));
  const std::uint64_t exposure = std::max(periods, next_exposure_);
  next_exposure_ = exposure + 1;
  const double t_s = static_cast<double>(exposure) / frame_rate_hz_;
  clock_.advance_to(std::max(t_s, clock_.now_s()));

  Frame frame{cv::Mat(region_px_.size(), CV_8UC1), region_px_, t_s, exposure};
  Random random(seed_, RandomStream::kFrame, exposure);
  noise_.fill_dark(frame.image, random);
  if (const std::optional<Light> seen = light(t_s)) {
    const cv::Rect lit_px = seen->window_px & region_px_;
    if (!lit_px.empty())
      noise_.expose(seen->levels(lit_px - seen->window_px.tl()),
                    frame.image(lit_px - region_px_.tl()), random);
  }
  return {FrameStatus::kOk, frame};
}

std::optional<Light> VirtualCamera::light(double t_s) {
  if (board_.X_BG()) return board_.render(t_s);
  return lamps_.render(arm_.X_BT(), lens_, t_s);
}

}  // namespace planar
