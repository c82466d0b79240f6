#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planar_servo/lens/camera_model.h"

namespace planar {

/// How uncertain fx, fy, cx, cy and the first distortion coefficients of a camera are.
struct CameraUncertainty {
  Eigen::MatrixXd by_residuals;             ///< covariance if the residuals are noise
  std::optional<Eigen::MatrixXd> by_views;  ///< as the views scatter; for visp without kdu
  std::vector<CameraModel> as_good{};       ///< of other models, which the views do not rule out
};

/// Returns the standard deviations of `camera`: of each parameter the larger one of both
/// covariances, and of fx, fy, cx and cy together with the largest difference to a model that is as
/// good.
Eigen::VectorXd deviations(const CameraUncertainty& uncertainty, const CameraModel& camera);

}  // namespace planar
