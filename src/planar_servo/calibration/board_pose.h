#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planar_servo/core/pose.h"
#include "planar_servo/lens/camera_model.h"

namespace planar {

struct BoardPose {
  Pose X_CG{Pose::Identity()};
  double rms_px{0.0};  ///< root of the mean square distance from seen to projected points
};

/// Estimates the pose of a flat board (points in its plane z_G = 0, metres) from the pixels of its
/// points. It solves the perspective-n-point problem on undistorted rays, then refines the pose by
/// least squares on them. Empty with fewer than 4 points, when a pixel has no ray, or when the
/// points do not determine a pose in front of the camera. Throws std::invalid_argument when there
/// are not as many pixels as points.
std::optional<BoardPose> estimate_board_pose(const CameraModel& camera,
                                             const std::vector<Eigen::Vector2d>& points_G,
                                             const std::vector<Eigen::Vector2d>& pixels);

/// Returns the seen minus the projected pixel of each point. Empty when a point has no projection.
std::optional<std::vector<Eigen::Vector2d>> board_residuals(
    const CameraModel& camera, const Pose& X_CG, const std::vector<Eigen::Vector2d>& points_G,
    const std::vector<Eigen::Vector2d>& pixels);

/// Returns the root of the mean square length of the residuals.
double rms_length(const std::vector<Eigen::Vector2d>& residuals);

}  // namespace planar
