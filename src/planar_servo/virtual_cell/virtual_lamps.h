#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_lens.h"

namespace planar {

/// Returns the exact fraction of each pixel of `window_px` that lies inside a simple closed polygon
/// (CV_32FC1, 0 to 1, of the window's size). Pixel (c, r) is the square c +- 1/2, r +- 1/2. The
/// polygon may turn either way and may leave the window. The signed areas to the right of its edges
/// are summed along the rows.
cv::Mat1f polygon_coverage(const std::vector<Eigen::Vector2d>& outline_px,
                           const cv::Rect& window_px);

/// Returns the smallest window that holds the outline with `margin_px` on each side.
cv::Rect window_around(const std::vector<Eigen::Vector2d>& outline_px, double margin_px);

/// Light on a part of the sensor.
struct Light {
  cv::Rect window_px;
  cv::Mat1f levels;  ///< grey levels above the background, of the window's size
};

/// Describes a lamp in the camera's view, with a linear map from pixels back to the lamp's plane.
struct SeenLamp {
  const LampTruth* lamp{nullptr};
  std::vector<Eigen::Vector2d> outline_px;
  Eigen::Vector2d center_px;
  Eigen::Matrix2d m_per_px;  ///< in the base's axes
  Eigen::Vector2d gradient;  ///< direction and slope of the disc's level, base axes
  Eigen::Vector2d halo;      ///< direction and strength of the halo, base axes
  cv::Rect window_px;        ///< holds its light before the blur
};

/// Sees a lamp, which must outlive what is returned, at `place_m` of a plane at X_BT. Empty when it
/// is not in front of the camera.
std::optional<SeenLamp> see_lamp(const LampTruth& lamp, const Eigen::Vector2d& place_m,
                                 const Pose& X_BT, const VirtualLens& lens, double t_s);

/// Returns the part of the sensor that the light of these lamps reaches.
cv::Rect light_window(const std::vector<SeenLamp>& lamps, double blur_px);

/// Renders these lamps without noise, each a disc in perspective with exact pixel coverage and its
/// glow, then blurred.
Light light_of(const std::vector<SeenLamp>& lamps, double blur_px);

/// Renders the lamps of the cell without noise.
class VirtualLamps {
 public:
  explicit VirtualLamps(const Truth& truth);

  /// Returns the outlines of what the tool's lamps sit in, which hides what lies below them.
  std::vector<std::vector<Eigen::Vector2d>> housings_px(const Pose& X_BT, const VirtualLens& lens,
                                                        double t_s) const;

  /// Renders the lamps of the tool at X_BT first, then those that are fixed to the base. Lights
  /// that overlap are merged.
  std::vector<Light> render_all(const Pose& X_BT, const VirtualLens& lens, double t_s) const;

 private:
  std::vector<SeenLamp> see_tool(const Pose& X_BT, const VirtualLens& lens, double t_s) const;

  std::array<LampTruth, 2> lamps_;
  std::array<Eigen::Vector2d, 2> places_m_;
  std::optional<TipTruth> tip_;
  LampTruth tip_lamp_;
  std::vector<ReferenceLampTruth> fixed_;
  double blur_px_;
};

}  // namespace planar
