#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "marker/blob.h"

namespace planar {

/// Finds bright patches that may be lamps, of 12 px diameter and more, in an image of any size.
/// A lamp must cross sparse rows, so only these are read; the threshold is learned from the image;
/// each run of bright pixels that is long enough for a lamp is grown to its connected blob.
class LampDetector {
 public:
  /// Candidates by falling evidence (diameter times contrast); those cut by the image's edge are
  /// among them. None for an image too small to hold a lamp. Throws std::invalid_argument for an
  /// image that is not CV_8UC1.
  std::vector<Blob> detect(const cv::Mat& image);

 private:
  struct Span {
    int v, begin, end;
  };

  void scan_row(const cv::Mat& image, int v, int threshold, std::vector<Blob>& found);
  /// Box of the connected pixels above the threshold round a span; empty when it grows too large.
  cv::Rect grow(const cv::Mat& image, const Span& seed, int threshold);

  std::vector<std::uint8_t> visited_;  ///< one per pixel; all zero between calls
  std::vector<Span> spans_;            ///< all spans visited in this call
};

}  // namespace planar
