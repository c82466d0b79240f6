#pragma once

#include <Eigen/Core>

#include "planar_servo/core/pose.h"

namespace planar {

/// Fits the rigid motion X_AB that minimises sum |X_AB p_B - p_A|^2 over the columns: a rotation
/// and a translation without scale or mirror [Kabsch 1976; Umeyama 1991]. Throws InputError for
/// points that are not finite or do not determine it (all in one place in 2-D, collinear in 3-D),
/// and std::invalid_argument for sets of different size.
Eigen::Isometry2d fit_rigid_2d(const Eigen::Matrix2Xd& p_A, const Eigen::Matrix2Xd& p_B);
Pose fit_rigid_3d(const Eigen::Matrix3Xd& p_A, const Eigen::Matrix3Xd& p_B);

}  // namespace planar
