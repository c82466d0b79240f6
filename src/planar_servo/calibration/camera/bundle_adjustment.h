#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planar_servo/calibration/camera_calibration.h"

namespace planar {

/// Holds one least-squares fit of a camera and the boards' poses. Nothing was left out or
/// corrected.
struct LensFit {
  CameraModel camera;
  std::vector<Pose> X_CG;           ///< one per view
  std::vector<double> view_rms_px;  ///< one per view
  bool converged{true};             ///< false when the iterations ran out
};

/// Fits the camera and the boards' poses to the pixels of all views by Levenberg and Marquardt
/// [Triggs et al. 1999], through the model's own projection, whatever lens it is. It starts from
/// the focal lengths that homographies give, without distortion, and adds the coefficients by and
/// by: one, then eight, then all. Empty when the views give no start or a point lies beyond the
/// lens model's range there.
std::optional<LensFit> fit_by_bundle(const std::vector<CalibrationView>& views, int width_px,
                                     int height_px, const CalibrationModel& model);

/// Holds the normal equations of a camera with all its views at the end of a fit. The poses are
/// eliminated.
struct FitInformation {
  Eigen::MatrixXd camera;  ///< of fx, fy, cx, cy and the free coefficients, for a noise of 1 px
  double squares{0.0};     ///< sum of the squared distances, px^2
  double parameters{0.0};  ///< how many there are, those of the poses included
  double freedom{0.0};     ///< coordinates less parameters
  double decrease{0.0};    ///< by which one more Gauss-Newton step would lower `squares`

  /// What one view adds to the gradient of half the squares, and to `camera`: the square of its
  /// Jacobian.
  struct OfView {
    Eigen::MatrixXd J_K;
    Eigen::VectorXd gradient;
  };
  std::vector<OfView> views;
};

/// Returns the normal equations of a fit. Empty when a point lies at the very end of the lens
/// model's range, beyond which it has no pixel.
std::optional<FitInformation> fit_information(const LensFit& fit,
                                              const std::vector<CalibrationView>& views,
                                              std::size_t free_coefficients);

/// Returns the covariance of the camera as the views scatter: the jackknife [Efron 1982] over views
/// left out one by one, each by a Gauss-Newton step. Unlike the inverse of the information times
/// the mean square residual it holds where a lens of another kind makes all residuals of a view
/// wrong together. Empty when the views without one of them do not determine the camera.
std::optional<Eigen::MatrixXd> scatter_over_views(const FitInformation& information);

/// Returns the covariance of parameters with these Jacobians, stacked, for a variance of 1: the
/// inverse of the sum of their squares. Empty when it is singular to working precision.
std::optional<Eigen::MatrixXd> covariance_from(const std::vector<Eigen::MatrixXd>& jacobians);

/// Returns the Jacobians of the camera by all views.
std::vector<Eigen::MatrixXd> jacobians_of(const FitInformation& information);

}  // namespace planar
