#pragma once

#include <Eigen/Core>
#include <vector>

namespace planar {

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
