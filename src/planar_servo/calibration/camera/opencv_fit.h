#pragma once

#include <optional>

#include "planar_servo/calibration/camera/lens_fit.h"

namespace planar {

/// Fits the camera by calibrateCamera or fisheye of OpenCV, which take points and pixels in single
/// precision. The fit starts again where it stopped until it stands still. Empty when OpenCV
/// refuses the views or gives numbers that make no camera.
std::optional<LensFit> fit_by_opencv(const std::vector<CalibrationView>& views, int width_px,
                                     int height_px, const FitModel& model);

}  // namespace planar
