#pragma once

#include <Eigen/Core>
#include <optional>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/geometry/lens/camera_model.h"

namespace planar {

/// Maps between the plane z_W = 0, in which the lamps move, and the pixels of a calibrated camera.
class Workplane {
 public:
  Workplane(const CameraModel& camera, const Pose& X_WC);

  /// Returns where the ray of a pixel meets the plane, in W (metres). Empty when the pixel has no
  /// ray or the ray does not meet the plane in front of the camera. Sets the Jacobian `d_p_d_uv`
  /// (m/px) unless it is null.
  std::optional<Eigen::Vector2d> plane_from_pixel(const Eigen::Vector2d& uv_px,
                                                  Eigen::Matrix2d* d_p_d_uv = nullptr) const;

  /// Returns the pixel of a point of the plane. Empty when the point is not in front of the camera
  /// or lies beyond the lens model's range. Sets the Jacobian `d_uv_d_p` (px/m) unless it is null.
  std::optional<Eigen::Vector2d> pixel_from_plane(const Eigen::Vector2d& p_W,
                                                  Eigen::Matrix2d* d_uv_d_p = nullptr) const;

  const CameraModel& camera() const { return camera_; }
  const Pose& X_WC() const { return X_WC_; }

 private:
  CameraModel camera_;
  Pose X_WC_;
  Pose X_CW_;
};

/// Returns the shift, in pixels, from the image of a disc's centre to the centre of the disc's
/// image, which is another point [Heikkila 2000]. The rim of a disc of the given diameter (metres)
/// about `p_GD` in the plane z_G = 0 is projected for it. Empty when part of the rim has no pixel.
std::optional<Eigen::Vector2d> eccentricity_px(const CameraModel& camera, const Pose& X_CG,
                                               const Eigen::Vector2d& p_GD, double diameter);

/// Returns the diameter, in metres, of a disc about `p_GD` whose image has the area `area_px2`.
/// Empty when the centre has no pixel.
std::optional<double> disc_diameter(const CameraModel& camera, const Pose& X_CG,
                                    const Eigen::Vector2d& p_GD, double area_px2);

}  // namespace planar
