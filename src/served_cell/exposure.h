#pragma once

#include <functional>
#include <opencv2/core.hpp>

namespace planar {

/// Takes a picture of a region, `brightness` times as bright as usual.
using Exposure = std::function<cv::Mat(const cv::Rect& region_px, double brightness)>;

}  // namespace planar
