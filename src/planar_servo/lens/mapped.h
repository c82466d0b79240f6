#pragma once

#include <Eigen/Core>

namespace planar::lens {

/// Holds a point of one normalised image plane and its Jacobian by the point of the other plane.
struct Mapped {
  Eigen::Vector2d xy{0.0, 0.0};
  Eigen::Matrix2d J = Eigen::Matrix2d::Identity();
};

}  // namespace planar::lens
