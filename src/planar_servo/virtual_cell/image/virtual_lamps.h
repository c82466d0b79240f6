#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "planar_servo/core/pose.h"
#include "planar_servo/virtual_cell/image/virtual_lens.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// Light that falls on a part of the sensor.
struct Light {
  cv::Rect window_px;
  cv::Mat1f levels;  ///< grey levels above the background, of the window's size
};

/// The image of both lamps, before any noise.
class VirtualLamps {
 public:
  explicit VirtualLamps(const Truth& truth);

  /// The lamps with the tool at X_BT, each a disc seen in true perspective whose pixels are covered
  /// exactly, with its glow, then blurred. Empty when no lamp is before the camera.
  std::optional<Light> render(const Pose& X_BT, const VirtualLens& lens, double t_s) const;

 private:
  std::array<LampTruth, 2> lamps_;
  std::array<Eigen::Vector2d, 2> places_m_;
  double blur_px_;
};

}  // namespace planar
