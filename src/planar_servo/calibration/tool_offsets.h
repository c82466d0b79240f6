#pragma once

#include <Eigen/Core>
#include <vector>

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

/// A point of the tool while joint 3 alone turns. `sweep` numbers the positions of the end point.
struct SweepPoint {
  int sweep{0};
  double phi{0.0};
  Eigen::Vector2d p{0.0, 0.0};  ///< base plane, metres
};

struct SweepOffset {
  Eigen::Vector2d offset{0.0, 0.0};  ///< the point in the turning tool, from the axis, metres
  double variance{0.0};              ///< of each coordinate, m^2
  std::vector<double>
      residuals;  ///< distances from the fitted positions, metres, in the points' order
};

/// Fits p_i = P_sweep(i) + R(phi_i) offset by least squares, with a free position P of the axis in
/// each sweep. With z = p - mean p and C = R - mean R per sweep, sum C^T C = s I and offset = sum
/// C^T z / s. Throws InputError when the angles vary so little that the offset would be less
/// certain than a single reading (s < 1).
SweepOffset fit_sweep_offset(const std::vector<SweepPoint>& points);

}  // namespace planar
