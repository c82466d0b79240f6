#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace planar::bench {

/// Returns the brightest level of a continuous 8-bit frame by AVX2: it reads every byte once and
/// does no more with it. Throws std::runtime_error on a machine without AVX2.
std::uint8_t brightest(const cv::Mat& frame);

/// Takes the frame out of the processor's caches.
void make_cold(const cv::Mat& frame);

}  // namespace planar::bench
