#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "planar_servo/lamps/detect/blob.h"

namespace planar::bench {

/// A way to find lamps in a full frame: their places and areas. `told_px` is the diameter of the
/// lamps, for those that must be told it.
struct DetectionMethodUnderTest {
  std::string name;
  /// On every n-th frame only, for the slow ones.
  int every{1};
  std::function<std::vector<Blob>(const cv::Mat& frame, double told_px)> detect;
};

/// The full read, which finds nothing, first; ours second.
std::vector<DetectionMethodUnderTest> detection_methods();

}  // namespace planar::bench
