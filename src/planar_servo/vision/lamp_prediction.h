#pragma once

#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

#include "planar_servo/core/pose.h"
#include "planar_servo/tool/coarse_view.h"
#include "planar_servo/vision/see_tool.h"

namespace planar {

/// Holds what is known of the place where images were taken.
struct LampScene {
  cv::Size sensor_px;
  LampLayout lamps;
  std::optional<VisionCalibration> vision;             ///< known once the workplane is calibrated
  std::vector<ReferenceLampLayout> reference_lamps{};  ///< fixed to the base, in view
  std::vector<Eigen::Vector2d> fixed_px{};             ///< where those are seen, once it is known
};

/// Predicts the lamps in an image from the commanded pose: their size, and their places as seen
/// through the calibrated workplane or else through a coarse view.
class LampPrediction {
 public:
  /// Takes the scene, which must outlive the prediction, and a coarse view if there is one.
  LampPrediction(const LampScene& scene, std::optional<CoarseView> view);

  /// Predicts the lamps for an end point commanded to `commanded` (base frame). Without a commanded
  /// pose, or where the view does not reach, only their size is predicted.
  PairExpectation of(const std::optional<TipPose>& commanded) const;

 private:
  std::optional<PairExpectation> by_view(const TipPose& commanded) const;

  const LampScene& scene_;
  std::optional<CoarseView> view_;
};

}  // namespace planar
