#pragma once

#include <optional>

#include "marker/blob.h"
#include "marker/lamp.h"
#include "marker/lamp_detector.h"

namespace planar {

/// Follows one bright disc through a sequence of images: by vpDot2 from its last place, by
/// detection near there when that fails.
class DiscTracker {
 public:
  /// `start_px` picks the disc in the first image that shows one there; without it the most
  /// evident one is taken.
  explicit DiscTracker(CenterMethod method, std::optional<Eigen::Vector2d> start_px = std::nullopt);

  /// The disc in the next CV_8UC1 image; kNoLamp when it is lost (it is looked for again near its
  /// last place in the next image).
  LampCenter locate(const cv::Mat& image);

 private:
  std::optional<Blob> find(const cv::Mat& image);

  CenterMethod method_;
  std::optional<Eigen::Vector2d> start_px_;
  std::optional<Blob> last_;
  LampDetector detector_;
};

}  // namespace planar
