#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>

namespace planar {

/// The exposure time at which a served camera without gain is as bright as usual.
constexpr std::uint32_t kUsualExposure_us = 10000;

/// Takes a picture of a region, `brightness` times as bright as usual.
using Exposure = std::function<cv::Mat(const cv::Rect& region_px, double brightness)>;

}  // namespace planar
