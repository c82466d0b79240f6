#pragma once

#include <optional>

#include "planar_servo/calibration/camera/lens_fit.h"

namespace planar {

/// Fits the camera by OpenCV's calibrateCamera or fisheye, which take points and pixels in single
/// precision. Starts again from where it stopped until the fit stands still. Empty when OpenCV
/// refuses the views or gives numbers that make no camera.
std::optional<LensFit> fit_by_opencv(const std::vector<CalibrationView>& views, int width_px,
                                     int height_px, const FitModel& model);

}  // namespace planar
