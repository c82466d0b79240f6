#include "planar_servo/calibration/camera/lens_fit.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/calibration/board/board_pose.h"
#include "planar_servo/calibration/camera/fit_information.h"
#include "planar_servo/calibration/camera/opencv_fit.h"
#include "planar_servo/calibration/camera/visp_fit.h"
#include "planar_servo/core/error.h"

namespace planar {
namespace {

constexpr char kViSP[] = "visp";
/// A focal length or a coordinate of the principal point counts as unknown when its standard
/// deviation exceeds this share of the focal length.
constexpr double kMostUncertain = 0.1;

[[noreturn]] void refuse(const FitModel& model) {
  throw WorkError("the views do not determine a camera of the model " + model.name +
                  "; take more of them, tilted in different directions, or a simpler model");
}

/// Points are taken as they are when their root mean square distance from their centroid lies
/// between these, in metres.
constexpr double kSmallBoard = 1.0 / 32.0, kLargeBoard = 1.0;

/// Returns the power of two, which changes no digit, that scales the points of a smaller or larger
/// board to a root mean square distance between an eighth and a quarter of a metre. Returns 1 for
/// other boards.
double normalising_scale(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d centroid(0.0, 0.0);
  for (const Eigen::Vector2d& p : points) centroid += p / static_cast<double>(points.size());
  double squares = 0.0;
  for (const Eigen::Vector2d& p : points) squares += (p - centroid).squaredNorm();
  const double rms = std::sqrt(squares / static_cast<double>(points.size()));
  if (rms >= kSmallBoard && rms <= kLargeBoard) return 1.0;
  int exponent = 0;
  std::frexp(rms, &exponent);
  return std::ldexp(1.0, -2 - exponent);
}

std::optional<LensFit> fit_normalised(const std::vector<CalibrationView>& views, int width_px,
                                      int height_px, const FitModel& model) {
  return model.lens == kViSP ? fit_by_visp(views, width_px, height_px)
                             : fit_by_opencv(views, width_px, height_px, model);
}

}  // namespace

const std::vector<FitModel>& fit_models() {
  static const std::vector<FitModel> models{{"pinhole", "pinhole", 0},
                                            {"plumb_bob_k1", "plumb_bob", 1},
                                            {"plumb_bob", "plumb_bob", 5},
                                            {"rational_polynomial", "rational_polynomial", 8},
                                            {"opencv_14", "opencv_14", 14},
                                            {"equidistant", "equidistant", 4},
                                            {"visp", kViSP, 2}};
  return models;
}

std::optional<LensFit> fit_lens(const std::vector<CalibrationView>& views, int width_px,
                                int height_px, const FitModel& model) {
  const double scale = normalising_scale(views.front().points_G);
  std::vector<CalibrationView> normalised = views;
  for (CalibrationView& view : normalised) {
    for (Eigen::Vector2d& p : view.points_G) p *= scale;
  }
  auto fit = fit_normalised(normalised, width_px, height_px, model);
  if (!fit) return std::nullopt;
  for (std::size_t i = 0; i < views.size(); ++i) {
    fit->X_CG[i].translation() /= scale;
    const auto residuals =
        board_residuals(fit->camera, fit->X_CG[i], views[i].points_G, views[i].pixels);
    if (!residuals) return std::nullopt;
    fit->view_rms_px.push_back(rms_length(*residuals));
  }
  return fit;
}

CameraUncertainty camera_uncertainty(const LensFit& fit, const std::vector<CalibrationView>& views,
                                     const FitModel& model) {
  const bool by_visp = model.lens == kViSP;
  const auto information = fit_information(fit, views, by_visp ? 1 : model.free_coefficients);
  if (!information) refuse(model);
  const auto covariance =
      by_visp ? visp_covariance(fit, views) : covariance_from(information->camera);
  if (!covariance) refuse(model);
  const CameraUncertainty uncertainty{*covariance * (information->squares / information->freedom),
                                      scatter_over_views(*information)};
  const Eigen::VectorXd sigma = deviations(uncertainty, fit.camera);
  const Intrinsics k = intrinsics(fit.camera);
  if (!sigma.allFinite() || sigma.head<4>().maxCoeff() > kMostUncertain * std::min(k.fx, k.fy))
    refuse(model);
  return uncertainty;
}

}  // namespace planar
