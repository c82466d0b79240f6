#include "planar_servo/vision/follow_region.h"

#include <algorithm>
#include <cmath>

namespace planar {

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

}  // namespace planar
