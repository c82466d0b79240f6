#pragma once

#include <opencv2/core.hpp>

namespace planar {

/// Equally spaced points of a straight line in an image: (u, v), then steps of (du, dv).
struct BandLine {
  float u, v, du, dv;
  float nu2, nv2;  ///< squared components of the line's direction
};

/// Interpolates an 8-bit image between the four pixels nearest to each of the 16 points of a line,
/// whose levels and blurs (see RimBand) it writes. A sample that is mostly of pixels at 255 is 255.
/// Points beyond the image take its outermost pixels.
void sample_line(const cv::Mat& image, const BandLine& line, float* level, float* blur_px2);

/// The same, to the last bit, eight points at a time. Only where `has_fast_lines()`, and when the
/// points lie at least 4 px inside the image.
void sample_line_fast(const cv::Mat& image, const BandLine& line, float* level, float* blur_px2);
bool has_fast_lines();

}  // namespace planar
