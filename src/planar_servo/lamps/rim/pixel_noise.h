#pragma once

#include <opencv2/core.hpp>

#include "planar_servo/lamps/rim/outline.h"

namespace planar {

/// The variance of a pixel's grey level as a line in the level: at_zero + per_level * level.
struct PixelNoise {
  double at_zero{0.0};
  double per_level{0.0};

  double variance(double level) const;
};

/// Estimates the noise from second differences along the rows, well inside and well outside the
/// lamp. Where one side does not tell (the lamp is clipped or small), the variance at level zero is
/// that of rounding and of half a level of read noise.
PixelNoise estimate_noise(const cv::Mat& image, const Outline& outline);

}  // namespace planar
