#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "planar_servo/core/pose.h"

namespace planar {

/// The derivative by (dc, dw) of something seen by a camera at the pose (c + dc, exp(dw) R) in W.
template <int N>
using PoseJacobian = Eigen::Matrix<double, N, 6>;

/// Returns where a ray, given in the camera's frame, meets the plane z_W = 0. Empty unless the
/// camera is above the plane and the ray meets it in front of the camera.
std::optional<Eigen::Vector2d> meet_plane(const Pose& X_WC, const Eigen::Vector3d& ray_C,
                                          PoseJacobian<2>* d_p_d_pose = nullptr);

/// The lamps' frame in the plane: the point midway between the lamps, metres, and the direction
/// from lamp 1 to lamp 2, radians.
struct LampsInPlane {
  Eigen::Vector2d middle{0.0, 0.0};
  double phi{0.0};
  PoseJacobian<2> d_middle_d_pose{PoseJacobian<2>::Zero()};
  PoseJacobian<1> d_phi_d_pose{PoseJacobian<1>::Zero()};
};

std::optional<LampsInPlane> lamps_in_plane(const Pose& X_WC,
                                           const std::array<Eigen::Vector3d, 2>& rays_C);

/// Returns the pose (c + dc, exp(dw) R) for `change` = (dc, dw).
Pose moved_pose(const Pose& X_WC, const Eigen::Matrix<double, 6, 1>& change);

}  // namespace planar
