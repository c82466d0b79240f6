#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/calibration/camera/camera_uncertainty.h"
#include "planar_servo/geometry/lens/lens_models.h"

namespace planar {

/// One picture of a flat board: points of its plane z_G = 0 (metres) and where they were seen.
struct CalibrationView {
  std::string name;
  std::vector<Eigen::Vector2d> points_G;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<double> dot_areas_px2;  ///< of round dots, one per point; empty for corners
};

struct CalibrationProblem {
  std::vector<CalibrationView> views;
  int width_px{0};
  int height_px{0};
  /// One of calibration_model_names().
  std::string model{"plumb_bob_k1"};
  /// Whether the camera is judged by views that are left out in turn, which takes five more fits.
  bool leaves_views_out{true};
};

struct CalibratedView {
  std::string name;
  Pose X_CG{Pose::Identity()};
  double rms_px{0.0};
  std::vector<Eigen::Vector2d> pixels;        ///< as fitted, dots' eccentricity taken off
  std::vector<Eigen::Vector2d> residuals_px;  ///< seen minus predicted, one per pixel
};

struct CameraCalibration {
  CameraModel camera;
  std::string model;    ///< the name asked for, or the one that `auto` chose
  bool is_auto{false};  ///< whether it did
  int width_px{0};
  int height_px{0};
  double rms_px{0.0};  ///< root of the mean square distance over all points used
  /// Of fx, fy, cx, cy and the distortion coefficients in the model's order; zero for coefficients
  /// that were fixed at zero, NaN for those that the views do not tell by themselves: traded_off().
  std::vector<double> standard_deviations;
  std::vector<CalibratedView> views;
  std::vector<Rejection> rejected;
  /// Over views left out of the fit, for which only their own poses were fitted; empty when the
  /// remaining views do not determine the camera, or none was to be left out.
  std::optional<double> held_out_rms_px;
  /// held_out_rms_px in metres, in a plane that faces the camera at the boards' median distance.
  std::optional<double> expected_error;
  /// At the boards' median distance, over the hull of the pixels used, beyond whose box the lens
  /// model extrapolates.
  PlaneError plane_error;
  double dot_diameter{0.0};  ///< metres, from the dots' areas; 0 without them
};

using CalibrationModels = std::vector<CalibrationModel>;

/// Returns the names of the models, and `auto`.
std::vector<std::string> calibration_model_names(
    const CalibrationModels& models = calibration_models());

/// Calibrates a camera by least squares on the pixel residuals of all views: by bundle adjustment
/// or, for `visp`, by ViSP's vpCalibration. The dots' centres are then corrected for their
/// eccentricity and the fit is repeated. A view that repeats another within the noise counts once.
/// Views with residuals far larger than the others' are left out one by one. `auto` takes the
/// simplest model whose held-out residuals are within one standard error of the best one's.
///
/// `without_board` lists pictures in which no board was found: they are added to the rejected views
/// and, when too few views are left, to the error message.
///
/// Throws InputError for an unknown model, fewer than 3 usable views, unequal numbers of points and
/// pixels, numbers that are not finite, or more than 256 views for `visp`; WorkError when the fit
/// does not converge or the views do not determine the camera.
CameraCalibration calibrate_camera(const CalibrationProblem& problem,
                                   const std::vector<Rejection>& without_board = {},
                                   const CalibrationModels& models = calibration_models());

}  // namespace planar
