#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/core/pose.h"
#include "planar_servo/tool/coarse_view.h"

namespace planar {

/// Returns the pose X_WC of a camera that sees points of the plane z_W = 0 along rays (x, y, 1) =
/// H_CW (X, Y, 1), up to a positive factor [Zhang 2000, sect. 3.1]. Throws InputError for a
/// mirrored homography, which would need a camera below the plane.
Pose pose_from_homography(const Eigen::Matrix3d& H_CW);

/// A plane in the camera's frame: its unit normal towards the camera, and the camera's distance,
/// metres.
struct CameraPlane {
  Eigen::Vector3d normal_C{0.0, 0.0, 1.0};
  double distance{0.0};
};

/// Returns the plane above which a board seen at X_CG has its points, by `points_height` (metres,
/// negative below). Throws InputError when the pose is not finite or the camera lies in the board.
CameraPlane board_plane(const Pose& X_CG, double points_height);

/// Returns the mean of planes that are nearly the same; throws InputError when there are none.
CameraPlane mean_plane(const std::vector<CameraPlane>& planes);

/// Returns the covariance of the mean of several planes of a camera at X_WC: of its height and of
/// its rotations about x_W and y_W. It is zero for a single one.
Eigen::Matrix3d scatter_of_planes(const Pose& X_WC, const std::vector<CameraPlane>& planes);

/// Returns a camera pose over this plane. Its origin and direction in the plane are arbitrary: the
/// origin lies under the camera, and x follows the image's rows.
Pose pose_over_plane(const CameraPlane& plane);

}  // namespace planar
