#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "planar_servo/virtual_cell/random.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// Turns grey levels into what an 8-bit sensor delivers: shot noise of variance level/gain, read
/// noise, rounded and clipped to 0..255.
class SensorNoise {
 public:
  SensorNoise(const NoiseTruth& truth, std::uint64_t seed);

  /// An image of nothing but background. Its rows are copied from random places of a bank of dark
  /// noise, because fresh noise on a whole sensor takes too long.
  void fill_dark(cv::Mat& image, Random& random) const;

  /// Fresh noise on the levels above the background (CV_32FC1) into `image` (CV_8UC1, same size).
  void expose(const cv::Mat1f& levels, cv::Mat image, Random& random) const;

 private:
  NoiseTruth truth_;
  std::vector<float> normals_;      ///< quantiles of the normal distribution
  std::vector<std::uint8_t> bank_;  ///< dark pixels
};

}  // namespace planar
