#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/arm/planar_arm.h"

namespace planar {

/// Gaussians over the postures of an arm. With u = (cos theta1, sin theta1, theta2 - theta1), in
/// which a whole turn of joint 1 leads back,
///
///     b_j(theta) = exp(-|u - c_j|^2 / (2 width^2)).
struct PostureBasis {
  Eigen::Matrix3Xd centers;
  double width{0.6};

  Eigen::Index terms() const { return centers.cols(); }
  Eigen::RowVectorXd at(const Joints& theta) const;
  /// Returns the matrix whose inverse is the prior covariance of the weights of a function of unit
  /// variance.
  Eigen::MatrixXd kernel_matrix() const;
};

/// Returns a basis of this width whose centres are some of these postures, spread evenly.
PostureBasis basis_over_postures(const std::vector<Joints>& postures, double width);

}  // namespace planar
