#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace planar {

/// How bright the lit part of an image is.
struct ExposureReading {
  int peak_level{0};            ///< grey level of its brightest part, a few hot pixels left out
  double saturated_share{0.0};  ///< of the lit pixels, those at 255

  bool too_dark() const;
  bool too_bright() const;
  /// In a line: a bar, the figures, and what to do.
  std::string text() const;
};

/// `image` is CV_8UC1 and not empty. Lit is what lies above the middle between the median level and
/// the peak.
ExposureReading read_exposure(const cv::Mat& image);

}  // namespace planar
