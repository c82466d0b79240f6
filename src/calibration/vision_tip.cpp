#include "calibration/vision_tip.h"

#include <cmath>

namespace planar {

std::optional<VisionTip> tip_from_lamps(const Workplane& workplane, const ToolOffsets& tool,
                                        const std::array<Eigen::Vector2d, 2>& lamps_px,
                                        const std::array<Eigen::Matrix2d, 2>& covariances_px2) {
  std::array<Eigen::Vector2d, 2> lamps_W;
  VisionTip seen;
  for (std::size_t k = 0; k < 2; ++k) {
    Eigen::Matrix2d J;
    const auto p_W = workplane.plane_from_pixel(lamps_px[k], &J);
    if (!p_W) return std::nullopt;
    lamps_W[k] = *p_W;
    seen.covariance += 0.25 * J * covariances_px2[k] * J.transpose();
  }
  const Eigen::Vector2d along = lamps_W[1] - lamps_W[0];
  seen.tip.phi = std::atan2(along.y(), along.x());
  seen.tip.p = 0.5 * (lamps_W[0] + lamps_W[1]) + rotation2d(seen.tip.phi) * tool.p_TP;
  return seen;
}

std::optional<std::array<Eigen::Vector2d, 2>> lamps_from_tip(const Workplane& workplane,
                                                             const ToolOffsets& tool,
                                                             double lamp_separation_m,
                                                             const TipPose& tip) {
  const Eigen::Matrix2d R = rotation2d(tip.phi);
  const Eigen::Vector2d middle = tip.p - R * tool.p_TP;
  const Eigen::Vector2d half = R * Eigen::Vector2d(0.5 * lamp_separation_m, 0.0);
  const auto first = workplane.pixel_from_plane(middle - half);
  const auto second = workplane.pixel_from_plane(middle + half);
  if (!first || !second) return std::nullopt;
  return std::array<Eigen::Vector2d, 2>{*first, *second};
}

}  // namespace planar
