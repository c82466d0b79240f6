#pragma once

#include <Eigen/Core>
#include <optional>

#include "planar_servo/core/pose.h"
#include "planar_servo/lens/camera_model.h"

namespace planar {

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
