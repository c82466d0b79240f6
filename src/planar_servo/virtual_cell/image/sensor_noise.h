#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "planar_servo/virtual_cell/random.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// Turns grey levels into the output of an 8-bit sensor: shot noise of variance level/gain, read
/// noise, rounding, clipping to 0..255.
class SensorNoise {
 public:
  SensorNoise(const NoiseTruth& truth, std::uint64_t seed);

  /// Fills `image` with noisy background. Rows are copied from random places in a bank of dark
  /// pixels, because fresh noise for a whole sensor takes too long.
  void fill_dark(cv::Mat& image, Random& random) const;

  /// Writes `levels` above the background (CV_32FC1) with fresh noise into `image` (CV_8UC1, same
  /// size).
  void expose(const cv::Mat1f& levels, cv::Mat image, Random& random) const;

 private:
  NoiseTruth truth_;
  std::vector<float> normals_;      ///< quantiles of the normal distribution
  std::vector<std::uint8_t> bank_;  ///< dark pixels
};

}  // namespace planar
