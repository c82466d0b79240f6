#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "planar_servo/lamps/blob.h"

namespace planar::bench {

/// A way to find lamps in a full frame. It returns their places and areas. `told_px` is the
/// diameter of the lamps, for methods that must be told it.
struct DetectionMethodUnderTest {
  std::string name;
  /// The method looks at every n-th frame only, where n is above 1 for slow methods.
  int every{1};
  std::function<std::vector<Blob>(const cv::Mat& frame, double told_px)> detect;
};

/// Returns all methods: first the full read, which finds nothing, then ours.
std::vector<DetectionMethodUnderTest> detection_methods();

}  // namespace planar::bench
