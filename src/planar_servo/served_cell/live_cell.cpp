#include "planar_servo/served_cell/live_cell.h"

#include <algorithm>

namespace planar {

LiveCell::LiveCell(const Truth& truth, const VirtualHardware& hardware, double age_s)
    : cell_(truth, hardware), sensor_px_(hardware.sensor_px), offset_s_(age_s - steady_.now_s()) {}

void LiveCell::set_mover(std::function<void(VirtualCell&)> mover) {
  const std::lock_guard<std::mutex> lock(mutex_);
  mover_ = std::move(mover);
}

cv::Mat LiveCell::expose(const cv::Rect& region_px, double brightness) {
  const std::lock_guard<std::mutex> lock(mutex_);
  catch_up();
  const cv::Rect seen_px = region_px & cv::Rect(cv::Point(), sensor_px_);
  if (seen_px == region_px) return cell_.expose(region_px, brightness, exposures_++);
  cv::Mat image(region_px.size(), CV_8UC1, cv::Scalar(0));
  if (!seen_px.empty())
    cell_.expose(seen_px, brightness, exposures_++).copyTo(image(seen_px - region_px.tl()));
  return image;
}

TipPose LiveCell::true_tip() {
  const std::lock_guard<std::mutex> lock(mutex_);
  catch_up();
  return cell_.true_tip();
}

void LiveCell::catch_up() {
  Clock& clock = cell_.clock();
  clock.sleep_for_s(std::max(0.0, steady_.now_s() + offset_s_ - clock.now_s()));
  if (mover_) mover_(cell_);
}

}  // namespace planar
