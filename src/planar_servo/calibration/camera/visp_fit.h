#pragma once

#include <Eigen/Core>
#include <optional>

#include "planar_servo/calibration/camera/lens_fit.h"

namespace planar {

/// Fits ViSP's lens by vpCalibration (CALIB_VIRTUAL_VS_DIST) to all views, started from OpenCV's
/// pinhole camera. It minimises at each point the distance from the pixel to the projection by kud
/// and the distance from the pixel undistorted by kdu to the projection without distortion. Empty
/// when one of the fits fails. Throws InputError for more than 256 views: vpCalibration writes
/// beyond its arrays then.
std::optional<LensFit> fit_by_visp(const std::vector<CalibrationView>& views, int width_px,
                                   int height_px);

/// Covariance of px, py, u0, v0, kud, kdu for a variance of 1 px^2 of each pixel coordinate. Each
/// coordinate enters both of its distances, so that they are not independent. Empty when the views
/// do not determine the camera.
std::optional<Eigen::MatrixXd> visp_covariance(const LensFit& fit,
                                               const std::vector<CalibrationView>& views);

}  // namespace planar
