#include "planar_servo/geometry/tool/vision_tip.h"

#include <cmath>

#include "planar_servo/geometry/lens/workplane.h"

namespace planar {

std::array<Eigen::Vector2d, 2> lamp_eccentricities_px(
    const Workplane& workplane, const std::array<Eigen::Vector2d, 2>& lamps_px,
    const std::array<double, 2>& diameters) {
  std::array<Eigen::Vector2d, 2> shifts{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  const Pose X_CW = workplane.X_WC().inverse();
  for (std::size_t k = 0; k < 2; ++k) {
    const auto p_W = workplane.plane_from_pixel(lamps_px[k]);
    if (!p_W || !(diameters[k] > 0.0)) continue;
    shifts[k] = eccentricity_px(workplane.camera(), X_CW, *p_W, diameters[k])
                    .value_or(Eigen::Vector2d::Zero());
  }
  return shifts;
}

TipPose tip_from_places(const std::array<Eigen::Vector2d, 2>& lamps_B, const ToolOffsets& tool) {
  const Eigen::Vector2d along = lamps_B[1] - lamps_B[0];
  const double phi = std::atan2(along.y(), along.x());
  return {0.5 * (lamps_B[0] + lamps_B[1]) + rotation2d(phi) * tool.p_TP, phi};
}

std::array<TipSlope, 2> tip_slopes(const std::array<Eigen::Vector2d, 2>& lamps_B,
                                   const ToolOffsets& tool) {
  const Eigen::Vector2d along = lamps_B[1] - lamps_B[0];
  const Eigen::Vector2d arm = rotation2d(std::atan2(along.y(), along.x())) * tool.p_TP;
  // A turn moves the end point about the middle of the lamps.
  const Eigen::Vector2d p_by_phi(-arm.y(), arm.x());
  const Eigen::RowVector2d phi_by_second =
      Eigen::RowVector2d(-along.y(), along.x()) / along.squaredNorm();
  std::array<TipSlope, 2> slopes;
  for (std::size_t k = 0; k < 2; ++k) {
    slopes[k].phi = k == 0 ? -phi_by_second : phi_by_second;
    slopes[k].p = 0.5 * Eigen::Matrix2d::Identity() + p_by_phi * slopes[k].phi;
  }
  return slopes;
}

std::optional<VisionTip> tip_from_lamps(const Workplane& workplane, const ToolOffsets& tool,
                                        const std::array<Eigen::Vector2d, 2>& lamps_px,
                                        const std::array<Eigen::Matrix2d, 2>& covariances_px2) {
  std::array<Eigen::Vector2d, 2> lamps_W;
  std::array<Eigen::Matrix2d, 2> covariances_W;
  for (std::size_t k = 0; k < 2; ++k) {
    Eigen::Matrix2d J;
    const auto p_W = workplane.plane_from_pixel(lamps_px[k], &J);
    if (!p_W) return std::nullopt;
    lamps_W[k] = *p_W;
    covariances_W[k] = J * covariances_px2[k] * J.transpose();
  }
  VisionTip seen;
  seen.tip = tip_from_places(lamps_W, tool);
  const auto slopes = tip_slopes(lamps_W, tool);
  double variance_phi = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    seen.covariance += slopes[k].p * covariances_W[k] * slopes[k].p.transpose();
    variance_phi += slopes[k].phi * covariances_W[k] * slopes[k].phi.transpose();
  }
  seen.sigma_phi = std::sqrt(variance_phi);
  seen.lamps_B = lamps_W;
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
