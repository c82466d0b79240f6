#pragma once

#include <Eigen/Core>
#include <optional>

#include "planar_servo/calibration/camera/bundle_adjustment.h"

namespace planar {

/// Fits the lens of ViSP to all views by vpCalibration (CALIB_VIRTUAL_VS_DIST), which starts from
/// the pinhole camera of fit_by_bundle(). It minimises two distances at each point: from the pixel
/// to the projection distorted by kud, and from the pixel undistorted by kdu to the projection
/// without distortion. Boards much smaller or larger than a quarter of a metre are scaled to it
/// inside, so that the board's unit does not matter. Empty when one of the fits fails. Throws
/// InputError for more than 256 views, because vpCalibration writes beyond its arrays then.
std::optional<LensFit> fit_by_visp(const std::vector<CalibrationView>& views, int width_px,
                                   int height_px);

/// Returns the covariance of px, py, u0, v0, kud, kdu for a variance of 1 px^2 of each pixel
/// coordinate. Each coordinate enters both distances of its point, so that they are not
/// independent. Empty when the views do not determine the camera.
std::optional<Eigen::MatrixXd> visp_covariance(const LensFit& fit,
                                               const std::vector<CalibrationView>& views);

}  // namespace planar
