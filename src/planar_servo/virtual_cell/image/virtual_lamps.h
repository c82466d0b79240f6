#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "planar_servo/core/pose.h"
#include "planar_servo/virtual_cell/image/virtual_lens.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// Light on a part of the sensor.
struct Light {
  cv::Rect window_px;
  cv::Mat1f levels;  ///< grey levels above the background, of the window's size
};

/// Renders both lamps without noise.
class VirtualLamps {
 public:
  explicit VirtualLamps(const Truth& truth);

  /// Renders the lamps with the tool at X_BT: each a disc in perspective with exact pixel coverage
  /// and its glow, then blurred. Returns nothing when no lamp is in front of the camera.
  std::optional<Light> render(const Pose& X_BT, const VirtualLens& lens, double t_s) const;

 private:
  std::array<LampTruth, 2> lamps_;
  std::array<Eigen::Vector2d, 2> places_m_;
  double blur_px_;
};

}  // namespace planar
