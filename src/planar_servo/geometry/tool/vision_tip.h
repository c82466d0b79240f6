#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include "planar_servo/base/core/pose.h"
#include "planar_servo/geometry/lens/workplane.h"

namespace planar {

/// Positions of the tool's points, metres. The lamps' frame has its origin midway between the lamps
/// a and b and its x axis from lamp 1 to lamp 2. T is that frame moved to the end point P, with z =
/// 0 in the base plane:
///
///     P = (a + b) / 2 + R(phi) p_TP,   reflector = P + R(phi) p_TS
struct ToolOffsets {
  Eigen::Vector2d p_TP{0.0, 0.0};       ///< end point in the lamps' frame
  Eigen::Vector3d p_TS{0.0, 0.0, 0.0};  ///< reflector in T
  bool reflector_known{true};           ///< false where no tracker saw it; p_TS is zero then
  /// Covariance of (p_TP x, y, p_TS x, y, z), m^2.
  Eigen::Matrix<double, 5, 5> covariance{Eigen::Matrix<double, 5, 5>::Zero()};
};

/// The end point as vision sees it, before any error map.
struct VisionTip {
  TipPose tip;                                          ///< base frame
  std::array<Eigen::Vector2d, 2> lamps_B;               ///< where the lamps are on the plane
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};  ///< of tip.p, from the lamps' pixels, m^2
  double sigma_phi{0.0};  ///< of tip.phi, from the lamps' pixels, radians
};

/// Returns the end point, and the direction from lamp 1 to lamp 2, of a tool whose lamps are at
/// these places on the plane.
TipPose tip_from_places(const std::array<Eigen::Vector2d, 2>& lamps_B, const ToolOffsets& tool);

/// How a tip changes with the place of one lamp.
struct TipSlope {
  Eigen::Matrix2d p{Eigen::Matrix2d::Zero()};          ///< d tip.p / d lamp
  Eigen::RowVector2d phi{Eigen::RowVector2d::Zero()};  ///< d tip.phi / d lamp, radians per metre
};

/// Returns the derivatives of tip_from_places() by the places of lamps 1 and 2.
std::array<TipSlope, 2> tip_slopes(const std::array<Eigen::Vector2d, 2>& lamps_B,
                                   const ToolOffsets& tool);

/// Returns the shifts in pixels from the images of the lamps' centres to the centres of their
/// images, for discs of these diameters (metres) in the plane; see eccentricity_px(). A shift is
/// zero where the lamp's ray does not meet the plane or its diameter is unknown (zero).
std::array<Eigen::Vector2d, 2> lamp_eccentricities_px(
    const Workplane& workplane, const std::array<Eigen::Vector2d, 2>& lamps_px,
    const std::array<double, 2>& diameters);

/// Computes P = middle of the lamps + R(phi) p_TP, with phi the direction from lamp 1 to lamp 2.
/// `lamps_px` are the lamps' centres without eccentricity. Empty when a lamp's ray does not meet
/// the plane.
std::optional<VisionTip> tip_from_lamps(const Workplane& workplane, const ToolOffsets& tool,
                                        const std::array<Eigen::Vector2d, 2>& lamps_px,
                                        const std::array<Eigen::Matrix2d, 2>& covariances_px2);

/// Returns the pixels of lamps 1 and 2 for an end point at `tip`; empty outside the view.
std::optional<std::array<Eigen::Vector2d, 2>> lamps_from_tip(const Workplane& workplane,
                                                             const ToolOffsets& tool,
                                                             double lamp_separation_m,
                                                             const TipPose& tip);

}  // namespace planar
