#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace planar {

/// One image of the camera. The centre of the sensor's top-left pixel is (0, 0), and pixel (c, r)
/// of `image` is sensor pixel (region_px.x + c, region_px.y + r).
struct Frame {
  cv::Mat image;        ///< CV_8UC1, of the region's size
  cv::Rect region_px;   ///< where the image lies on the sensor
  double t_s{0.0};      ///< when the exposure began, on the source's clock
  std::uint64_t id{0};  ///< the camera's own frame number
};

}  // namespace planar
