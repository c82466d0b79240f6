#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planar_servo/calibration/camera_calibration.h"

namespace planar {

/// One least-squares fit of a camera and the boards' poses, without any view left out or corrected.
struct LensFit {
  CameraModel camera;
  std::vector<Pose> X_CG;           ///< one per view
  std::vector<double> view_rms_px;  ///< one per view
  bool converged{true};             ///< false when the iterations ran out
};

/// Fits the camera and the boards' poses to the pixels of all views by Levenberg and Marquardt
/// [Triggs et al. 1999], through the model's own projection, whatever the lens. It starts from the
/// focal lengths that homographies give, without distortion, and adds the coefficients in steps:
/// one, then eight, then all. Empty when the views give no start or a point lies beyond the lens
/// model's range at the start.
std::optional<LensFit> fit_by_bundle(const std::vector<CalibrationView>& views, int width_px,
                                     int height_px, const CalibrationModel& model);

/// The normal equations of a camera with all its views at the end of a fit, the poses eliminated.
struct FitInformation {
  Eigen::MatrixXd camera;  ///< of fx, fy, cx, cy and the free coefficients, for a noise of 1 px
  double squares{0.0};     ///< sum of the squared distances, px^2
  double parameters{0.0};  ///< how many there are, those of the poses included
  double freedom{0.0};     ///< coordinates less parameters
  double decrease{0.0};    ///< by which one more Gauss-Newton step would lower `squares`

  std::vector<Eigen::MatrixXd> jacobians;  ///< of each view; their squares add up to `camera`
  std::vector<Eigen::VectorXd> gradients;  ///< what each view adds to that of half the squares
};

/// Returns the normal equations of a fit. Empty when a point lies at the very end of the lens
/// model's range.
std::optional<FitInformation> fit_information(const LensFit& fit,
                                              const std::vector<CalibrationView>& views,
                                              std::size_t free_coefficients);

/// Returns the covariance of the camera by the scatter over views: the sum of the squares of what
/// each view pulls, its residuals scaled by what the fit leaves of them [Bell & McCaffrey 2002].
/// Where residuals are noise it is, in the mean, the inverse information times their mean square;
/// unlike that it stays valid when a lens of another kind correlates the residuals within a view.
/// Empty where a parameter has no effect.
std::optional<Eigen::MatrixXd> scatter_over_views(const FitInformation& information);

/// Returns independent steps, as columns, of parameters with these Jacobians, stacked: each is as
/// long as its deviation for a variance of 1, and their squares add up to the covariance, the
/// inverse of the sum of the Jacobians' squares. Steps without an effect beyond rounding are very
/// long. Empty where a parameter has no effect.
std::optional<Eigen::MatrixXd> independent_steps(const std::vector<Eigen::MatrixXd>& jacobians);
std::optional<Eigen::MatrixXd> covariance_from(const std::vector<Eigen::MatrixXd>& jacobians);

/// Returns the parameters whose deviations by the covariance do not hold: much of their variance
/// belongs to independent steps that do not raise the sum of squares by about the variance, as they
/// should. Such terms (k1 to k6 of the rational model, tilt, tangential terms and principal point
/// of opencv_14) make up for each other along curves, which no covariance describes.
std::vector<Eigen::Index> traded_off(const LensFit& fit, const std::vector<CalibrationView>& views,
                                     std::size_t free_coefficients);

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

/// Removes each view that repeats an earlier one, and names both in `rejected`. A view repeats
/// another when it shows the same points and their pixels are closer (root mean square) than three
/// times the noise of these distances, as in two photographs of a board at rest. The noise is what
/// the best small motion of the board, which is smooth, leaves of the distances.
void drop_repeated_views(std::vector<CalibrationView>& views, std::vector<Rejection>& rejected);

}  // namespace planar
