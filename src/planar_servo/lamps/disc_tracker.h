#pragma once

#include <optional>
#include <vector>

#include "planar_servo/lamps/blob.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/lamps/lamp_detector.h"
#include "planar_servo/lamps/vp_dot_tracker.h"

namespace planar {

/// Follows one bright disc through a sequence of images: the nearest patch of about the same
/// size that is brighter than half its last contrast. With kVpDot2 a vpDot2 follows it (see
/// VpDotTracker), and such a patch is looked for when that has lost it.
class DiscTracker {
 public:
  /// `start_px` picks the disc in the first image that shows one there; without it the most
  /// evident one is taken.
  explicit DiscTracker(CenterMethod method, std::optional<Eigen::Vector2d> start_px = std::nullopt);

  /// The disc in the next CV_8UC1 image; kNoLamp when it is lost (it is looked for again near its
  /// last place in the next image).
  LampCenter locate(const cv::Mat& image);

 private:
  std::optional<Blob> find_again(const cv::Mat& image);
  std::optional<Blob> find_first(const cv::Mat& image);

  CenterMethod method_;
  std::optional<Eigen::Vector2d> start_px_;
  std::optional<Blob> last_;
  LampDetector detector_;
  PatchGrower patches_;
  VpDotTracker dot_;
  std::vector<Blob> found_;
};

}  // namespace planar
