#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/calibration/camera/camera_uncertainty.h"
#include "planar_servo/calibration/camera_calibration.h"

namespace planar {

/// Says how the camera of one calibration model is fitted.
struct FitModel {
  std::string name;               ///< as `--model` has it
  std::string lens;               ///< the lens model's name
  std::size_t free_coefficients;  ///< how many of its first coefficients are estimated
};

/// Returns every model that can be fitted.
const std::vector<FitModel>& fit_models();

/// Holds one least-squares fit of a camera and the boards' poses. Nothing was left out or
/// corrected.
struct LensFit {
  CameraModel camera;
  std::vector<Pose> X_CG;           ///< one per view
  std::vector<double> view_rms_px;  ///< one per view
  bool converged{true};             ///< false when the iterations ran out
};

/// Fits a camera of that model to the views: by ViSP's vpCalibration for the lens visp, else by
/// OpenCV's calibrateCamera and fisheye. Boards much smaller or larger than a quarter of a metre
/// are scaled to it inside, so that the board's unit does not matter. Empty when the fit fails, as
/// it may where the views do not determine the camera.
std::optional<LensFit> fit_lens(const std::vector<CalibrationView>& views, int width_px,
                                int height_px, const FitModel& model);

/// Returns how uncertain fx, fy, cx, cy and the distortion coefficients that are estimated are,
/// from the fit's residuals and Jacobian, with the poses eliminated by their Schur complement, and
/// from the scatter over views. Throws WorkError when the views do not determine the camera: when
/// some combination of its parameters can change without any effect, or when a focal length or the
/// principal point is uncertain by a tenth of the focal length.
CameraUncertainty camera_uncertainty(const LensFit& fit, const std::vector<CalibrationView>& views,
                                     const FitModel& model);

}  // namespace planar
