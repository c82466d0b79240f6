#pragma once

#include <opencv2/core.hpp>

namespace planar {

/// Describes equally spaced points of a straight line in an image: they begin at (u, v) and go on
/// in steps of (du, dv).
struct BandLine {
  float u, v, du, dv;
  float nu2, nv2;  ///< squared components of the line's direction
};

/// Interpolates an 8-bit image at the 16 points of a line, each between the four nearest pixels,
/// and writes levels and blurs (see RimBand). A sample whose pixels are mostly at 255 becomes 255.
/// Points outside the image take its outermost pixels.
void sample_line(const cv::Mat& image, const BandLine& line, float* level, float* blur_px2);

/// Does what sample_line() does, to the last bit, eight points at a time. Call it only where
/// has_fast_lines() and with all points at least 4 px inside the image.
void sample_line_fast(const cv::Mat& image, const BandLine& line, float* level, float* blur_px2);
bool has_fast_lines();

}  // namespace planar
