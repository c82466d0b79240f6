#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace planar {

/// Says how bright the lit part of an image is.
struct ExposureReading {
  int peak_level{0};            ///< grey level of the brightest part, without a few hot pixels
  double saturated_share{0.0};  ///< share of the lit pixels that are at 255

  /// Returns true when the lamps use less than half of the grey levels.
  bool too_dark() const;
  /// Returns true when more than 2 % of the lit pixels are saturated.
  bool too_bright() const;
  /// Returns one line with a bar, the figures, and what to do.
  std::string text() const;
};

/// Reads the exposure of an image, which is CV_8UC1 and not empty. Pixels are lit that lie above
/// the middle between the median level and the peak.
ExposureReading read_exposure(const cv::Mat& image);

}  // namespace planar
