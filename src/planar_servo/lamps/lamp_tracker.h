#pragma once

#include <vector>

#include "planar_servo/devices/frame.h"
#include "planar_servo/lamps/detect/lamp_detector.h"
#include "planar_servo/lamps/lamp.h"

namespace planar {

/// Finds the two lamps in a frame (whole sensor or region): where a prediction is given, in a
/// window round each predicted place; without one, or when that fails, in the whole image. Then
/// measures each centre by the method asked for, checks the distance and decides which lamp is
/// which. Keeps no state that changes a result: the same frame and expectation always give the same
/// pair (only memory is kept from frame to frame).
class LampTracker {
 public:
  explicit LampTracker(CenterMethod method) : method_(method) {}

  LampPair locate(const Frame& frame, const PairExpectation& expectation);

 private:
  void search_windows(const cv::Mat& image, const PairExpectation& expectation);
  void search_image(const cv::Mat& image);
  LampPair measure(const cv::Mat& image, const PairExpectation& expectation) const;

  CenterMethod method_;
  LampDetector detector_;
  std::vector<Blob> candidates_;
};

}  // namespace planar
