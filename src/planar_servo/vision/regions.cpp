#include "planar_servo/vision/regions.h"

#include <algorithm>
#include <cmath>

namespace planar {

cv::Rect follow_region(const CameraSettings& camera, const Eigen::Vector2d& center_px) {
  const int width = std::min(camera.follow_region_px, camera.width_px);
  const int height = std::min(camera.follow_region_px, camera.height_px);
  const auto start = [](double center, int size, int sensor) {
    const double wanted = std::clamp(center - size / 2.0, 0.0, static_cast<double>(sensor - size));
    return static_cast<int>(std::lround(wanted));
  };
  return {start(center_px.x(), width, camera.width_px),
          start(center_px.y(), height, camera.height_px), width, height};
}

}  // namespace planar
