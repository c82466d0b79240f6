#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planar_servo/geometry/lens/camera_model.h"

namespace planar {

/// How uncertain fx, fy, cx, cy and the first distortion coefficients of a camera are.
struct CameraUncertainty {
  Eigen::MatrixXd by_residuals;             ///< covariance if the residuals are noise
  std::optional<Eigen::MatrixXd> by_views;  ///< as the views scatter; for visp without kdu
  std::vector<CameraModel> as_good{};       ///< of other models, which the views do not rule out
  std::vector<Eigen::Index> traded_off{};   ///< parameters whose deviations do not hold
};

/// Returns the standard deviations of `camera`: for each parameter the larger one by both
/// covariances; for fx, fy, cx and cy combined with the largest difference from a model that is as
/// good. NaN for those that trade off.
Eigen::VectorXd deviations(const CameraUncertainty& uncertainty, const CameraModel& camera);

/// The uncertainty that a camera's model causes at points of a plane that faces it: what is left of
/// the error once the plane's pose has been fitted over the same part of the picture, as in every
/// recording. It therefore excludes shift, turn, height and tilt.
struct PlaneError {
  double distance{0.0};                                ///< from the camera to the plane, metres
  Eigen::Vector2d from_px{0.0, 0.0}, to_px{0.0, 0.0};  ///< box about the part of the picture
  /// Standard deviations of a point's error, both axes together, metres: on a grid over the box, a
  /// row for each v. NaN outside the hull of the points seen, where the lens model extrapolates,
  /// and where a pixel has no ray.
  Eigen::MatrixXd sigma;

  double mean() const;
  double largest() const;
  /// Returns the deviation at the nearest pixel of the grid; NaN where there is none.
  double at(const Eigen::Vector2d& uv_px) const;
};

/// Propagates the camera's uncertainty to a plane, over the hull of the pixels that were `seen`. At
/// each point the larger of both covariances counts, combined with the largest difference from a
/// model that is as good.
PlaneError plane_error(const CameraModel& camera, const CameraUncertainty& uncertainty,
                       const std::vector<Eigen::Vector2d>& seen, double distance);

}  // namespace planar
