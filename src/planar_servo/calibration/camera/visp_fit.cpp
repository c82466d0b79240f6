#include <visp3/vision/vpCalibration.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/calibration/camera/lens_fit.h"
#include "planar_servo/geometry/lens/lens_models.h"

namespace planar {
namespace {

constexpr std::size_t kMostViews = 256;  // vpCalibration's fixed arrays
constexpr double kRelativeStep = 1e-6;   // of numerical derivatives

/// Makes vpCalibration take full Gauss-Newton steps instead of quarter steps, which need hundreds
/// of iterations. It also restores the precision of std::cout, which vpCalibration changes.
class VispSettings {
 public:
  VispSettings() : gain_(vpCalibration::getLambda()), precision_(std::cout.precision()) {
    vpCalibration::setLambda(1.0);
  }
  ~VispSettings() {
    vpCalibration::setLambda(gain_);
    std::cout.precision(precision_);
  }
  VispSettings(const VispSettings&) = delete;
  VispSettings& operator=(const VispSettings&) = delete;

 private:
  double gain_;
  std::streamsize precision_;
};

/// Points are taken as they are when their root mean square distance from their centroid lies
/// between these, in metres.
constexpr double kSmallBoard = 1.0 / 32.0, kLargeBoard = 1.0;

/// Returns the power of two, which changes no digit, that scales the points of a smaller or larger
/// board to a root mean square distance between an eighth and a quarter of a metre. Returns 1 for
/// other boards.
double normalising_scale(const std::vector<Eigen::Vector2d>& points) {
  const double rms = rms_length(about_centroid(points));
  if (rms >= kSmallBoard && rms <= kLargeBoard) return 1.0;
  int exponent = 0;
  std::frexp(rms, &exponent);
  return std::ldexp(1.0, -2 - exponent);
}

std::vector<vpCalibration> visp_views(const std::vector<CalibrationView>& views, double scale) {
  std::vector<vpCalibration> result(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t j = 0; j < views[i].pixels.size(); ++j) {
      vpImagePoint pixel(views[i].pixels[j].y(), views[i].pixels[j].x());
      const Eigen::Vector2d p = scale * views[i].points_G[j];
      result[i].addPoint(p.x(), p.y(), 0.0, pixel);
    }
  }
  return result;
}

Pose pose_from(const vpHomogeneousMatrix& M_CG) {
  Pose X_CG = Pose::Identity();
  for (unsigned row = 0; row < 3; ++row) {
    for (unsigned column = 0; column < 4; ++column) X_CG(row, column) = M_CG[row][column];
  }
  return X_CG;
}

/// Holds what a point's two distances depend on: px, py, u0, v0, kud, kdu, the point in the camera
/// frame, the pixel.
using Variables = Eigen::Matrix<double, 11, 1>;

Variables variables(const VispModel& camera, const Eigen::Vector3d& p_C,
                    const Eigen::Vector2d& uv) {
  const Intrinsics& k = camera.k;
  Variables v;
  v << k.fx, k.fy, k.cx, k.cy, camera.kud, camera.kdu, p_C, uv;
  return v;
}

/// Returns the projected minus the seen pixel, then the pixel projected without distortion minus
/// the seen pixel without its distortion.
Eigen::Vector4d distances(const Variables& v) {
  const Eigen::Vector2d f = v.head<2>(), c = v.segment<2>(2), uv = v.tail<2>();
  const Eigen::Vector2d xy = v.segment<2>(6) / v(8);
  const Eigen::Vector2d xy_d = (uv - c).cwiseQuotient(f);
  Eigen::Vector4d result;
  result << f.cwiseProduct(xy * (1.0 + v(4) * xy.squaredNorm())) + c - uv,
      f.cwiseProduct(xy - xy_d * (1.0 + v(5) * xy_d.squaredNorm()));
  return result;
}

Eigen::Matrix<double, 4, 11> jacobian_of_distances(const Variables& at) {
  Eigen::Matrix<double, 4, 11> J;
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    const double step = kRelativeStep * std::max(1.0, std::abs(at(i)));
    Variables less = at, more = at;
    less(i) -= step;
    more(i) += step;
    J.col(i) = (distances(more) - distances(less)) / (2.0 * step);
  }
  return J;
}

/// Holds the Jacobian of the camera with one view, whose pose is eliminated, and the
/// covariance of the gradient for a variance of 1 px^2 of each pixel coordinate.
struct ViewShare {
  Eigen::MatrixXd own, gradient;
};

ViewShare share_of(const VispModel& camera, const Pose& X_CG, const CalibrationView& view) {
  const Eigen::Index rows = 4 * static_cast<Eigen::Index>(view.pixels.size());
  Eigen::MatrixXd J_K(rows, 6), J_CG(rows, 6), J_I(rows, 2);
  for (std::size_t i = 0; i < view.pixels.size(); ++i) {
    const Eigen::Vector2d& p = view.points_G[i];
    const Eigen::Vector3d rotated = X_CG.linear() * Eigen::Vector3d(p.x(), p.y(), 0.0);
    const auto J =
        jacobian_of_distances(variables(camera, rotated + X_CG.translation(), view.pixels[i]));
    const Eigen::Index row = 4 * static_cast<Eigen::Index>(i);
    J_K.middleRows<4>(row) = J.leftCols<6>();
    J_CG.middleRows<4>(row) << J.middleCols<3>(6), -J.middleCols<3>(6) * cross_matrix(rotated);
    J_I.middleRows<4>(row) = J.rightCols<2>();
  }
  const Eigen::MatrixXd of_pose = solve_symmetric(J_CG.transpose() * J_CG, J_CG.transpose() * J_K);
  const Eigen::MatrixXd own = J_K - J_CG * of_pose;
  ViewShare share{own, Eigen::MatrixXd::Zero(6, 6)};
  for (Eigen::Index row = 0; row < rows; row += 4) {
    const Eigen::MatrixXd influence = own.middleRows<4>(row).transpose() * J_I.middleRows<4>(row);
    share.gradient += influence * influence.transpose();
  }
  return share;
}

}  // namespace

std::optional<LensFit> fit_by_visp(const std::vector<CalibrationView>& views, int width_px,
                                   int height_px) {
  if (views.size() > kMostViews)
    throw InputError({std::to_string(views.size()) + " views; ViSP's calibration holds at most " +
                          std::to_string(kMostViews),
                      "give it fewer or take another model"});
  const auto pinhole = fit_by_bundle(views, width_px, height_px, {"pinhole", Pinhole{}, 0});
  if (!pinhole) return std::nullopt;
  const Intrinsics start = intrinsics(pinhole->camera);
  vpCameraParameters camera(start.fx, start.fy, start.cx, start.cy);
  const double scale = normalising_scale(views.front().points_G);
  std::vector<vpCalibration> calibrations = visp_views(views, scale);
  const VispSettings settings;
  double rms_px = 0.0;
  try {
    vpCalibration::computeCalibrationMulti(vpCalibration::CALIB_VIRTUAL_VS_DIST, calibrations,
                                           camera, rms_px);
  } catch (const vpException&) {  // how ViSP says that it did not converge
    return std::nullopt;
  }
  const Intrinsics k{camera.get_px(), camera.get_py(), camera.get_u0(), camera.get_v0()};
  LensFit fit;
  try {
    fit.camera = CameraModel(VispModel{}).lens().with(k, {camera.get_kud(), camera.get_kdu()});
  } catch (const InputError&) {
    return std::nullopt;  // numbers that are not finite
  }
  for (std::size_t i = 0; i < views.size(); ++i) {
    Pose& X_CG = fit.X_CG.emplace_back(pose_from(calibrations[i].cMo_dist));
    X_CG.translation() /= scale;
    const auto residuals = board_residuals(fit.camera, X_CG, views[i].points_G, views[i].pixels);
    if (!residuals) return std::nullopt;
    fit.view_rms_px.push_back(rms_length(*residuals));
  }
  return fit;
}

std::optional<Eigen::MatrixXd> visp_covariance(const LensFit& fit,
                                               const std::vector<CalibrationView>& views) {
  const VispModel& camera = *fit.camera.as<VispModel>();
  std::vector<Eigen::MatrixXd> jacobians;
  Eigen::MatrixXd gradient = Eigen::MatrixXd::Zero(6, 6);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const ViewShare share = share_of(camera, fit.X_CG[i], views[i]);
    jacobians.push_back(share.own);
    gradient += share.gradient;
  }
  const auto inverse = covariance_from(jacobians);
  if (!inverse) return std::nullopt;
  return *inverse * gradient * *inverse;
}

}  // namespace planar
