#pragma once

#include <Eigen/Core>

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

}  // namespace planar
