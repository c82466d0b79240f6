#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/calibration/camera_calibration.h"

namespace planar {

/// One least-squares fit of a camera and the boards' poses, nothing left out or corrected.
struct LensFit {
  CameraModel camera;
  std::vector<Pose> X_CG;           ///< one per view
  std::vector<double> view_rms_px;  ///< one per view
};

/// Fits one of pinhole, plumb_bob_k1, plumb_bob, rational_polynomial, opencv_14 and equidistant by
/// OpenCV's calibrateCamera and fisheye. Empty when the views do not determine it.
std::optional<LensFit> fit_lens(const std::vector<CalibrationView>& views, int width_px,
                                int height_px, const std::string& model);

/// Standard deviations of fx, fy, cx, cy and the first `free_coefficients` distortion coefficients
/// (zero for the others) from the fit's residuals and Jacobian, the poses eliminated by their Schur
/// complement.
std::vector<double> standard_deviations(const LensFit& fit,
                                        const std::vector<CalibrationView>& views,
                                        std::size_t free_coefficients);

}  // namespace planar
