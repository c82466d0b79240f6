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

/// The pose of a flat board (points in its plane z_G = 0, metres) from the pixels of its points:
/// the perspective-n-point problem on undistorted rays, then least squares on them. Empty with
/// fewer than 4 points, when a pixel has no ray, or when the points do not determine a pose in
/// front of the camera. Throws std::invalid_argument when points and pixels are not as many.
std::optional<BoardPose> estimate_board_pose(const CameraModel& camera,
                                             const std::vector<Eigen::Vector2d>& points_G,
                                             const std::vector<Eigen::Vector2d>& pixels);

/// Seen minus projected pixel of each point; empty when one of them has no projection.
std::optional<std::vector<Eigen::Vector2d>> board_residuals(
    const CameraModel& camera, const Pose& X_CG, const std::vector<Eigen::Vector2d>& points_G,
    const std::vector<Eigen::Vector2d>& pixels);

/// Root of the mean square length of residuals.
double rms_length(const std::vector<Eigen::Vector2d>& residuals);

}  // namespace planar
