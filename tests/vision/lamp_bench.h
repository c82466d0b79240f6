#pragma once

#include <opencv2/core.hpp>
#include <random>

#include "planar_servo/geometry/lens/lens_models.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/loop/vision/see_tool.h"
#include "support/rendered_lamp.h"

namespace planar::test {

inline const cv::Size kSensor{640, 480};
constexpr double kHeight_m = 1.0;
constexpr double kPixelsPerMetre = 1000.0;
constexpr double kSeparation_m = 0.1;
constexpr double kDiameter_m = 0.04;

/// Looks straight down on the middle of the plane; y_W points against v.
inline Workplane workplane_below() {
  const Pinhole camera{
      {kPixelsPerMetre, kPixelsPerMetre, 0.5 * kSensor.width, 0.5 * kSensor.height}};
  Pose X_WC = Pose::Identity();
  X_WC.linear() = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  X_WC.translation() = Eigen::Vector3d(0.0, 0.0, kHeight_m);
  return {camera, X_WC};
}

/// Equal lamps on an ideal tool.
inline VisionCalibration vision_with(const std::optional<VisionErrorMap>& map) {
  return {{kSeparation_m, {kDiameter_m, kDiameter_m}}, workplane_below(), {}, map};
}

/// A picture of the whole sensor with both lamps of a tool that stands at `tip`, its lamps this far
/// apart.
inline cv::Mat picture_of(const TipPose& tip, std::mt19937& random,
                          double separation_m = kSeparation_m) {
  const auto lamps_px = lamps_from_tip(workplane_below(), {}, separation_m, tip).value();
  cv::Mat scene = background(kSensor);
  for (const Eigen::Vector2d& center_px : lamps_px)
    add_lamp(scene, {center_px, kDiameter_m * kPixelsPerMetre});
  return expose(scene, random);
}

}  // namespace planar::test
