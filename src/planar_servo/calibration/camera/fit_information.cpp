#include "planar_servo/calibration/camera/fit_information.h"

#include "planar_servo/calibration/board/board_pose.h"
#include "planar_servo/core/numerics/decompositions.h"
#include "planar_servo/core/pose.h"

namespace planar {
namespace {

constexpr double kCoefficientStep = 1e-5;
/// Least eigenvalue of an information matrix scaled to a diagonal of ones. Below it rounding
/// decides about the inverse.
constexpr double kLeastEigenvalue = 1e-15;

/// Holds the camera with one distortion coefficient a step less and a step more.
struct MovedCameras {
  CameraModel less, more;
};

std::vector<MovedCameras> moved_cameras(const CameraModel& camera, std::size_t free_coefficients) {
  const auto moved = [&](std::size_t c, double step) {
    auto coefficients = distortion_coefficients(camera);
    coefficients[c] += step;
    return make_camera_model(lens_model_name(camera), intrinsics(camera), coefficients);
  };
  std::vector<MovedCameras> result;
  for (std::size_t c = 0; c < free_coefficients; ++c)
    result.push_back({moved(c, -kCoefficientStep), moved(c, kCoefficientStep)});
  return result;
}

/// Holds the residuals of one view and their Jacobians J_K, by fx, fy, cx, cy and the free
/// distortion coefficients, and J_CG, by the board's pose. Those by the coefficients are central
/// differences, because all models are nearly linear in them.
struct LinearisedView {
  Eigen::VectorXd residuals;
  Eigen::MatrixXd J_K, J_CG;
  double rms_px{0.0};
};

std::optional<LinearisedView> linearised(const CameraModel& camera,
                                         const std::vector<MovedCameras>& moved, const Pose& X_CG,
                                         const CalibrationView& view) {
  const auto residuals = board_residuals(camera, X_CG, view.points_G, view.pixels);
  if (!residuals) return std::nullopt;
  const Eigen::Index rows = 2 * static_cast<Eigen::Index>(view.pixels.size());
  const Intrinsics k = intrinsics(camera);
  LinearisedView result;
  result.rms_px = rms_length(*residuals);
  result.residuals.resize(rows);
  result.J_K.resize(rows, 4 + static_cast<Eigen::Index>(moved.size()));
  result.J_CG.resize(rows, 6);
  for (std::size_t i = 0; i < view.pixels.size(); ++i) {
    const Eigen::Index row = 2 * static_cast<Eigen::Index>(i);
    const Eigen::Vector3d rotated =
        X_CG.linear() * Eigen::Vector3d(view.points_G[i].x(), view.points_G[i].y(), 0.0);
    const Eigen::Vector3d p_C = rotated + X_CG.translation();
    Eigen::Matrix<double, 2, 3> d_uv_d_p;
    const auto uv = project(camera, p_C, &d_uv_d_p);
    if (!uv) return std::nullopt;
    result.residuals.segment<2>(row) = (*residuals)[i];
    result.J_CG.middleRows<2>(row) << d_uv_d_p, -d_uv_d_p * cross_matrix(rotated);
    result.J_K.block<2, 4>(row, 0) << (uv->x() - k.cx) / k.fx, 0.0, 1.0, 0.0, 0.0,
        (uv->y() - k.cy) / k.fy, 0.0, 1.0;
    for (std::size_t c = 0; c < moved.size(); ++c) {
      const auto less = project(moved[c].less, p_C);
      const auto more = project(moved[c].more, p_C);
      if (!less || !more) return std::nullopt;
      result.J_K.block<2, 1>(row, 4 + static_cast<Eigen::Index>(c)) =
          (*more - *less) / (2.0 * kCoefficientStep);
    }
  }
  return result;
}

}  // namespace

std::optional<FitInformation> fit_information(const LensFit& fit,
                                              const std::vector<CalibrationView>& views,
                                              std::size_t free_coefficients) {
  const std::vector<MovedCameras> moved = moved_cameras(fit.camera, free_coefficients);
  const Eigen::Index parameters = 4 + static_cast<Eigen::Index>(free_coefficients);
  FitInformation sum;
  sum.camera = Eigen::MatrixXd::Zero(parameters, parameters);
  sum.parameters = static_cast<double>(parameters) + 6.0 * static_cast<double>(views.size());
  sum.freedom = -sum.parameters;
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(parameters);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto view = linearised(fit.camera, moved, fit.X_CG[i], views[i]);
    if (!view) return std::nullopt;
    const double points = static_cast<double>(views[i].pixels.size());
    const Eigen::MatrixXd mixed = view->J_CG.transpose() * view->J_K;
    const Eigen::MatrixXd pose = view->J_CG.transpose() * view->J_CG;
    const Eigen::VectorXd pose_gradient = view->J_CG.transpose() * view->residuals;
    const Eigen::VectorXd pose_step = solve_symmetric(pose, pose_gradient);
    sum.views.push_back(
        {view->J_K.transpose() * view->J_K - mixed.transpose() * solve_symmetric(pose, mixed),
         view->J_K.transpose() * view->residuals - mixed.transpose() * pose_step});
    sum.camera += sum.views.back().camera;
    gradient += sum.views.back().gradient;
    sum.decrease += pose_gradient.dot(pose_step);
    sum.squares += view->rms_px * view->rms_px * points;
    sum.freedom += 2.0 * points;
  }
  sum.decrease += gradient.dot(Eigen::VectorXd(solve_symmetric(sum.camera, gradient)));
  return sum;
}

std::optional<Eigen::MatrixXd> scatter_over_views(const FitInformation& information) {
  const auto n = static_cast<double>(information.views.size());
  Eigen::MatrixXd steps(information.camera.rows(), information.views.size());
  for (std::size_t i = 0; i < information.views.size(); ++i) {
    const FitInformation::OfView& view = information.views[i];
    const auto inverse = covariance_from(information.camera - view.camera);
    if (!inverse) return std::nullopt;
    steps.col(static_cast<Eigen::Index>(i)) = *inverse * view.gradient;
  }
  steps.colwise() -= steps.rowwise().mean().eval();
  return Eigen::MatrixXd((n - 1.0) / n * steps * steps.transpose());
}

std::optional<Eigen::MatrixXd> covariance_from(const Eigen::MatrixXd& information) {
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  if (!scaled.allFinite()) return std::nullopt;
  if (!(symmetric_eigenvalues(scaled)[0] > kLeastEigenvalue)) return std::nullopt;
  return solve_symmetric(information,
                         Eigen::MatrixXd::Identity(information.rows(), information.cols()));
}

}  // namespace planar
