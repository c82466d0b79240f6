#pragma once

#include <atomic>
#include <mutex>
#include <opencv2/core.hpp>
#include <vector>

#include "planar_servo/base/core/clock.h"

namespace planar::test {

/// A sensor without noise that knows every pixel of its scene and remembers its exposures.
class SceneSensor {
 public:
  std::atomic<bool> frozen{false};   ///< shows its last picture again and again
  std::atomic<double> delay_s{0.0};  ///< delays the next picture, once
  std::atomic<double> pace_s{0.0};   ///< that every picture takes

  /// Takes a picture of a region of the sensor. `brightness` is only remembered.
  cv::Mat expose(const cv::Rect& region_px, double brightness) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!frozen) {
      exposures_s_.push_back(clock_.now_s());
      brightness_ = brightness;
    }
    const auto shot = static_cast<int>(exposures_s_.size()) - 1;
    cv::Mat image(region_px.size(), CV_8UC1);
    for (int row = 0; row < image.rows; ++row)
      for (int column = 0; column < image.cols; ++column)
        image.at<std::uint8_t>(row, column) = level(region_px.x + column, region_px.y + row, shot);
    clock_.sleep_for_s(pace_s + delay_s.exchange(0.0));
    return image;
  }

  /// Returns the level of sensor pixel (u, v) in exposure number `shot`.
  static std::uint8_t level(int u, int v, int shot) {
    return static_cast<std::uint8_t>((3 * u + 5 * v + shot) & 0xff);
  }

  /// Returns true when `image` is exactly what some exposure shows of the region.
  static bool shows(const cv::Mat& image, const cv::Rect& region_px) {
    if (image.size() != region_px.size()) return false;
    const int shot = image.at<std::uint8_t>(0, 0) - level(region_px.x, region_px.y, 0);
    for (int row = 0; row < image.rows; ++row)
      for (int column = 0; column < image.cols; ++column)
        if (image.at<std::uint8_t>(row, column) !=
            level(region_px.x + column, region_px.y + row, shot))
          return false;
    return true;
  }

  /// Returns when the exposure began that `image` shows. It must be one of the last 256.
  double exposed_s(const cv::Mat& image, const cv::Rect& region_px) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const int shot = image.at<std::uint8_t>(0, 0) - level(region_px.x, region_px.y, 0);
    auto at = static_cast<int>(exposures_s_.size()) - 1;
    while (at > 0 && ((at - shot) & 0xff) != 0) --at;
    return exposures_s_.at(static_cast<std::size_t>(at));
  }

  /// Returns the number of exposures.
  std::size_t exposures() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return exposures_s_.size();
  }

  /// Returns the brightness of the last exposure.
  double brightness() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return brightness_;
  }

 private:
  std::mutex mutex_;
  SteadyClock clock_;
  std::vector<double> exposures_s_;
  double brightness_{0.0};
};

}  // namespace planar::test
