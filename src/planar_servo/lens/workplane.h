#pragma once

#include <Eigen/Core>
#include <optional>

#include "planar_servo/core/pose.h"
#include "planar_servo/lens/camera_model.h"

namespace planar {

/// The plane z_W = 0 in which the lamps move, seen by a calibrated camera.
class Workplane {
 public:
  Workplane(const CameraModel& camera, const Pose& X_WC);

  /// Where the ray of a pixel meets the plane, in W (metres); d_p_d_uv, when asked for, is its
  /// Jacobian in m/px. Empty when the pixel has no ray or the ray does not meet the plane in front
  /// of the camera.
  std::optional<Eigen::Vector2d> plane_from_pixel(const Eigen::Vector2d& uv_px,
                                                  Eigen::Matrix2d* d_p_d_uv = nullptr) const;

  /// The pixel of a point of the plane; empty when it is not in front of the camera or beyond the
  /// lens model. d_uv_d_p in px/m.
  std::optional<Eigen::Vector2d> pixel_from_plane(const Eigen::Vector2d& p_W,
                                                  Eigen::Matrix2d* d_uv_d_p = nullptr) const;

  const CameraModel& camera() const { return camera_; }
  const Pose& X_WC() const { return X_WC_; }

 private:
  CameraModel camera_;
  Pose X_WC_;
  Pose X_CW_;
};

}  // namespace planar
