#pragma once

#include <opencv2/core/types.hpp>
#include <optional>

#include "planar_servo/calibration/coarse_view.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/vision/see_tool.h"

namespace planar {

/// What is known of the place where images were taken.
struct LampScene {
  cv::Size sensor_px;
  LampLayout lamps;
  std::optional<VisionCalibration> vision;  ///< once the workplane is known
};

/// Says what is known of the lamps in an image: their size, and where they should be, from the
/// commanded pose through the workplane or else through a coarse view.
class LampPrediction {
 public:
  /// The scene must outlive the prediction.
  LampPrediction(const LampScene& scene, std::optional<CoarseView> view);

  /// The lamps with the end point commanded to `commanded` (base frame), as far as that is known.
  PairExpectation of(const std::optional<TipPose>& commanded) const;

 private:
  std::optional<PairExpectation> by_view(const TipPose& commanded) const;

  const LampScene& scene_;
  std::optional<CoarseView> view_;
};

}  // namespace planar
