#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>

namespace planar {

/// The exposure time at which a served camera with a gain of 0 dB has brightness 1.
constexpr std::uint32_t kUsualExposure_us = 10000;

/// Takes a picture of a region, `brightness` times as bright as usual.
using Exposure = std::function<cv::Mat(const cv::Rect& region_px, double brightness)>;

}  // namespace planar
