#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <utility>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/calibration/camera/lens_fit.h"

namespace planar {
namespace {

constexpr double kCoefficientStep = 1e-5;
/// Least singular value of a Jacobian scaled to columns of length 1. Below it the rounding of its
/// differences decides about the inverse; the parameters change together without any effect then.
constexpr double kLeastSingularValue = 1e-8;
/// Least share of a residual that a fit leaves where one view alone tells a combination.
constexpr double kLeastLeft = 1e-6;

constexpr int kMostSteps = 300;
constexpr double kFirstDamping = 1e-3, kLeastDamping = 1e-8, kMostDamping = 1e9;
/// A fit has converged when one more step would move its parameters by less than this share of
/// their uncertainty, which enlarges their error by an eighth at most.
constexpr double kConvergedShare = 0.5;
/// The fit runs until this holds for every combination of the parameters, or until a step lowers
/// the squares by less than this part of the variance, because terms that trade off against each
/// other, as in the rational model, never stop creeping. Then it takes a few more steps, until the
/// share is small. Where terms creep, these steps are damped so strongly that the terms stay in
/// place instead of diverging together.
constexpr double kCreeping = 0.01;
constexpr int kFinishingSteps = 5;
constexpr double kFinishedShare = 1e-3, kFinishingDamping = 1e-6;
/// Noise of a pixel coordinate below which no fit has to go.
constexpr double kLeastNoise_px = 1e-6;

/// Holds the normal equations of one view: by fx, fy, cx, cy and the free coefficients, by the
/// board's pose, and mixed.
struct ViewEquations {
  Eigen::MatrixXd camera, mixed, pose;
  Eigen::MatrixXd J_K;  ///< of the camera, the pose eliminated
  Eigen::VectorXd camera_gradient, pose_gradient;
  double squares{0.0}, points{0.0};
};

/// The camera with one distortion coefficient a step more and a step less.
struct MovedCameras {
  CameraModel more, less;
};

std::vector<MovedCameras> moved_cameras(const CameraModel& camera, Eigen::Index parameters) {
  std::vector<MovedCameras> moved;
  for (Eigen::Index c = 4; c < parameters; ++c) {
    const Eigen::VectorXd step = kCoefficientStep * Eigen::VectorXd::Unit(parameters, c);
    moved.push_back({moved_camera(camera, step), moved_camera(camera, -step)});
  }
  return moved;
}

/// Returns the equations of a view. The derivatives by the coefficients are differences to both
/// sides: coefficients that trade off nearly cancel, which one-sided differences would spoil. Empty
/// when a point has no pixel.
std::optional<ViewEquations> equations_of(const CameraModel& camera,
                                          const std::vector<MovedCameras>& moved, const Pose& X_CG,
                                          const CalibrationView& view) {
  const Intrinsics k = intrinsics(camera);
  const Eigen::Index rows = 2 * static_cast<Eigen::Index>(view.pixels.size());
  Eigen::MatrixXd J_K(rows, 4 + static_cast<Eigen::Index>(moved.size())), J_CG(rows, 6);
  Eigen::VectorXd residuals(rows);
  for (std::size_t i = 0; i < view.pixels.size(); ++i) {
    const Eigen::Index row = 2 * static_cast<Eigen::Index>(i);
    const Eigen::Vector3d rotated =
        X_CG.linear() * Eigen::Vector3d(view.points_G[i].x(), view.points_G[i].y(), 0.0);
    const Eigen::Vector3d p_C = rotated + X_CG.translation();
    Eigen::Matrix<double, 2, 3> d_uv_d_p;
    const auto uv = project(camera, p_C, &d_uv_d_p);
    if (!uv) return std::nullopt;
    residuals.segment<2>(row) = view.pixels[i] - *uv;
    J_CG.middleRows<2>(row) << d_uv_d_p, -d_uv_d_p * cross_matrix(rotated);
    J_K.block<2, 4>(row, 0) << (uv->x() - k.cx) / k.fx, 0.0, 1.0, 0.0, 0.0, (uv->y() - k.cy) / k.fy,
        0.0, 1.0;
    for (std::size_t c = 0; c < moved.size(); ++c) {
      const auto more = project(moved[c].more, p_C), less = project(moved[c].less, p_C);
      if (!more || !less) return std::nullopt;
      J_K.block<2, 1>(row, 4 + static_cast<Eigen::Index>(c)) =
          (*more - *less) / (2.0 * kCoefficientStep);
    }
  }
  ViewEquations result;
  result.camera = J_K.transpose() * J_K;
  result.mixed = J_CG.transpose() * J_K;
  result.pose = J_CG.transpose() * J_CG;
  result.J_K = J_K - J_CG * solve_symmetric(result.pose, result.mixed);
  result.camera_gradient = J_K.transpose() * residuals;
  result.pose_gradient = J_CG.transpose() * residuals;
  result.squares = residuals.squaredNorm();
  result.points = static_cast<double>(view.pixels.size());
  return result;
}

/// Eliminates the poses from the normal equations by their Schur complement.
FitInformation information_of(const std::vector<ViewEquations>& views) {
  const Eigen::Index parameters = views.front().camera.rows();
  FitInformation sum;
  sum.camera = Eigen::MatrixXd::Zero(parameters, parameters);
  sum.parameters = static_cast<double>(parameters) + 6.0 * static_cast<double>(views.size());
  sum.freedom = -sum.parameters;
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(parameters);
  for (const ViewEquations& view : views) {
    const Eigen::VectorXd pose_step = solve_symmetric(view.pose, view.pose_gradient);
    sum.jacobians.push_back(view.J_K);
    sum.gradients.emplace_back(view.camera_gradient - view.mixed.transpose() * pose_step);
    sum.camera += view.J_K.transpose() * view.J_K;
    gradient += sum.gradients.back();
    sum.decrease += view.pose_gradient.dot(pose_step);
    sum.squares += view.squares;
    sum.freedom += 2.0 * view.points;
  }
  sum.decrease += gradient.dot(Eigen::VectorXd(solve_symmetric(sum.camera, gradient)));
  return sum;
}

double variance_of(const FitInformation& information) {
  return std::max(information.squares / information.freedom, kLeastNoise_px * kLeastNoise_px);
}

/// Returns the largest share of its uncertainty by which one more step would move any combination
/// of the parameters. A step as large as the uncertainty of one of them lowers the sum of squares
/// by the variance.
double share_to_go(const FitInformation& information) {
  return std::sqrt(std::max(0.0, information.decrease) / variance_of(information));
}

/// Returns whether all parameters together have converged as far as each of them must.
bool has_converged(const FitInformation& information) {
  return share_to_go(information) <= kConvergedShare * std::sqrt(information.parameters);
}

Eigen::MatrixXd damped(Eigen::MatrixXd normal, double damping) {
  normal.diagonal() *= 1.0 + damping;
  return normal;
}

/// A camera with the boards' poses, and the normal equations about them.
class Bundle {
 public:
  /// Returns the bundle. Empty when a point has no pixel or the camera is at a limit of its model.
  static std::optional<Bundle> about(const CameraModel& camera, const std::vector<Pose>& X_CG,
                                     const std::vector<CalibrationView>& views,
                                     Eigen::Index parameters) {
    Bundle bundle{camera, X_CG};
    try {
      const std::vector<MovedCameras> moved = moved_cameras(camera, parameters);
      for (std::size_t i = 0; i < views.size(); ++i) {
        auto of_view = equations_of(camera, moved, X_CG[i], views[i]);
        if (!of_view) return std::nullopt;
        bundle.equations_.push_back(std::move(*of_view));
      }
    } catch (const InputError&) {
      return std::nullopt;
    }
    bundle.information_ = information_of(bundle.equations_);
    return bundle;
  }

  const CameraModel& camera() const { return camera_; }
  const std::vector<Pose>& X_CG() const { return X_CG_; }
  const FitInformation& information() const { return information_; }
  Eigen::Index parameters() const { return information_.camera.rows(); }

  std::vector<double> view_rms_px() const {
    std::vector<double> rms;
    for (const ViewEquations& view : equations_)
      rms.push_back(std::sqrt(view.squares / view.points));
    return rms;
  }

  /// Returns the bundle after a step of Levenberg and Marquardt.
  std::optional<Bundle> stepped(double damping, const std::vector<CalibrationView>& views) const {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(parameters(), parameters());
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(parameters());
    for (const ViewEquations& view : equations_) {
      const Eigen::MatrixXd pose = damped(view.pose, damping);
      normal +=
          damped(view.camera, damping) - view.mixed.transpose() * solve_symmetric(pose, view.mixed);
      gradient +=
          view.camera_gradient - view.mixed.transpose() * solve_symmetric(pose, view.pose_gradient);
    }
    const Eigen::VectorXd step = solve_symmetric(normal, gradient);
    if (!step.allFinite()) return std::nullopt;
    std::vector<Pose> poses = X_CG_;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const ViewEquations& view = equations_[i];
      const Eigen::VectorXd move =
          solve_symmetric(damped(view.pose, damping), view.pose_gradient - view.mixed * step);
      poses[i].translation() += move.head<3>();
      poses[i].linear() = rotation_from_vector(move.tail<3>()) * poses[i].linear();
    }
    try {
      return about(moved_camera(camera_, step), poses, views, parameters());
    } catch (const InputError&) {
      return std::nullopt;  // impossible parameters of a camera
    }
  }

 private:
  Bundle(const CameraModel& camera, const std::vector<Pose>& X_CG) : camera_(camera), X_CG_(X_CG) {}

  CameraModel camera_;
  std::vector<Pose> X_CG_;
  std::vector<ViewEquations> equations_;
  FitInformation information_;
};

/// Returns the bundle after the step with the least damping, from this one on, that lowers the sum
/// of squares. Empty when none does.
std::optional<Bundle> lowered(const Bundle& bundle, double& damping,
                              const std::vector<CalibrationView>& views) {
  for (; damping < kMostDamping; damping *= 10.0) {
    auto next = bundle.stepped(damping, views);
    if (next && next->information().squares < bundle.information().squares) return next;
  }
  return std::nullopt;
}

Bundle adjusted(Bundle bundle, const std::vector<CalibrationView>& views) {
  double damping = kFirstDamping;
  int finishing = 0;
  bool creeps = false;
  for (int step = 0; step < kMostSteps && finishing < kFinishingSteps; ++step) {
    const FitInformation& before = bundle.information();
    const double share = share_to_go(before);
    if (share <= kFinishedShare) break;
    if (share <= kConvergedShare) {
      ++finishing;
    } else if (creeps && has_converged(before)) {
      ++finishing;
      damping = std::max(damping, kFinishingDamping);
    }
    auto next = lowered(bundle, damping, views);
    if (!next) break;
    creeps = before.squares - next->information().squares < kCreeping * variance_of(before);
    bundle = std::move(*next);
    damping = std::max(kLeastDamping, 0.1 * damping);
  }
  return bundle;
}

/// Returns the pinhole camera that homographies give, its principal point in the image's middle.
Intrinsics start_by_homographies(const std::vector<CalibrationView>& views, int width_px,
                                 int height_px) {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const CalibrationView& view : views) {
    auto& of_board = points.emplace_back();
    auto& seen = pixels.emplace_back();
    for (const Eigen::Vector2d& p : view.points_G)
      of_board.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
    for (const Eigen::Vector2d& uv : view.pixels)
      seen.emplace_back(static_cast<float>(uv.x()), static_cast<float>(uv.y()));
  }
  const cv::Matx33d K = cv::initCameraMatrix2D(points, pixels, {width_px, height_px}, 0.0);
  return {K(0, 0), K(1, 1), K(0, 2), K(1, 2)};
}

std::vector<Pose> start_poses(const CameraModel& camera,
                              const std::vector<CalibrationView>& views) {
  std::vector<Pose> poses;
  for (const CalibrationView& view : views) {
    const auto pose = estimate_board_pose(camera, view.points_G, view.pixels);
    if (!pose) return {};
    poses.push_back(pose->X_CG);
  }
  return poses;
}

}  // namespace

std::optional<LensFit> fit_by_bundle(const std::vector<CalibrationView>& views, int width_px,
                                     int height_px, const CalibrationModel& model) try {
  const CameraModel start =
      model.sample.lens().with(start_by_homographies(views, width_px, height_px), {});
  const std::vector<Pose> poses = start_poses(start, views);
  if (poses.empty()) return std::nullopt;
  const auto parameters = 4 + static_cast<Eigen::Index>(model.free_coefficients);
  std::optional<Bundle> bundle = Bundle::about(start, poses, views, 4);
  if (!bundle) return std::nullopt;
  bundle = adjusted(std::move(*bundle), views);
  for (Eigen::Index coefficients = 1; bundle->parameters() < parameters; coefficients *= 8) {
    const auto richer = Bundle::about(bundle->camera(), bundle->X_CG(), views,
                                      std::min(4 + coefficients, parameters));
    if (!richer) return std::nullopt;
    bundle = adjusted(*richer, views);
  }
  return LensFit{bundle->camera(), bundle->X_CG(), bundle->view_rms_px(),
                 has_converged(bundle->information())};
} catch (const cv::Exception&) {  // how OpenCV refuses views
  return std::nullopt;
} catch (const InputError&) {  // focal lengths that are not finite
  return std::nullopt;
}

std::optional<FitInformation> fit_information(const LensFit& fit,
                                              const std::vector<CalibrationView>& views,
                                              std::size_t free_coefficients) {
  const auto bundle =
      Bundle::about(fit.camera, fit.X_CG, views, 4 + static_cast<Eigen::Index>(free_coefficients));
  if (!bundle) return std::nullopt;
  return bundle->information();
}

std::optional<Eigen::MatrixXd> scatter_over_views(const FitInformation& information) {
  const auto independent = independent_steps(information.jacobians);
  if (!independent) return std::nullopt;
  const Eigen::Index n = independent->cols();
  Eigen::MatrixXd steps(information.camera.rows(), information.jacobians.size());
  for (std::size_t i = 0; i < information.jacobians.size(); ++i) {
    const Eigen::MatrixXd J = information.jacobians[i] * *independent;
    const SingularValues left =
        singular_values(Eigen::MatrixXd::Identity(n, n) - J.transpose() * J);
    const Eigen::VectorXd grown = left.values.cwiseMax(kLeastLeft).cwiseSqrt().cwiseInverse();
    const Eigen::VectorXd pull = independent->transpose() * information.gradients[i];
    steps.col(static_cast<Eigen::Index>(i)) =
        *independent * (left.V * grown.cwiseProduct(left.V.transpose() * pull));
  }
  steps.colwise() -= steps.rowwise().mean().eval();
  return Eigen::MatrixXd(steps * steps.transpose());
}

std::optional<Eigen::MatrixXd> independent_steps(const std::vector<Eigen::MatrixXd>& jacobians) {
  Eigen::Index rows = 0;
  for (const Eigen::MatrixXd& J : jacobians) rows += J.rows();
  Eigen::MatrixXd stacked(rows, jacobians.at(0).cols());
  for (const Eigen::MatrixXd& J : jacobians) {
    rows -= J.rows();
    stacked.middleRows(rows, J.rows()) = J;
  }
  const Eigen::VectorXd scale = stacked.colwise().norm().cwiseInverse();
  stacked *= scale.asDiagonal();
  if (!stacked.allFinite()) return std::nullopt;
  const SingularValues svd = singular_values(stacked);
  const Eigen::VectorXd lengths = svd.values.cwiseMax(kLeastSingularValue).cwiseInverse();
  return scale.asDiagonal() * svd.V * lengths.asDiagonal();
}

std::optional<Eigen::MatrixXd> covariance_from(const std::vector<Eigen::MatrixXd>& jacobians) {
  const auto steps = independent_steps(jacobians);
  if (!steps) return std::nullopt;
  return *steps * steps->transpose();
}

}  // namespace planar
