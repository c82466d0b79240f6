#include "planar_servo/calibration/lens_fit.h"

#include <Eigen/Cholesky>
#include <opencv2/calib3d.hpp>

#include "planar_servo/calibration/board/board_pose.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/pose.h"

namespace planar {
namespace {

constexpr int kIterations = 60;
constexpr double kRelativeChange = 1e-10;
constexpr double kCoefficientStep = 1e-5;

/// The views as OpenCV takes them, and what it returns.
struct OpenCvProblem {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  cv::Size size;
  cv::Mat camera_matrix{cv::Mat::eye(3, 3, CV_64F)};
  cv::Mat coefficients;
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
};

const cv::TermCriteria kStop{cv::TermCriteria::COUNT + cv::TermCriteria::EPS, kIterations,
                             kRelativeChange};

OpenCvProblem opencv_problem(const std::vector<CalibrationView>& views, cv::Size size) {
  OpenCvProblem problem;
  problem.size = size;
  for (const CalibrationView& view : views) {
    auto& points = problem.points.emplace_back();
    auto& pixels = problem.pixels.emplace_back();
    for (std::size_t i = 0; i < view.pixels.size(); ++i) {
      points.emplace_back(static_cast<float>(view.points_G[i].x()),
                          static_cast<float>(view.points_G[i].y()), 0.0F);
      pixels.emplace_back(static_cast<float>(view.pixels[i].x()),
                          static_cast<float>(view.pixels[i].y()));
    }
  }
  return problem;
}

int flags_of(const std::string& model) {
  const int radial_one = cv::CALIB_ZERO_TANGENT_DIST | cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3;
  if (model == "pinhole") return radial_one | cv::CALIB_FIX_K1;
  if (model == "plumb_bob_k1") return radial_one;
  if (model == "rational_polynomial") return cv::CALIB_RATIONAL_MODEL;
  if (model == "opencv_14") {
    return cv::CALIB_RATIONAL_MODEL | cv::CALIB_THIN_PRISM_MODEL | cv::CALIB_TILTED_MODEL;
  }
  return 0;
}

void run_perspective(OpenCvProblem& problem, const std::string& model) {
  cv::calibrateCamera(problem.points, problem.pixels, problem.size, problem.camera_matrix,
                      problem.coefficients, problem.rotations, problem.translations,
                      flags_of(model), kStop);
}

/// Started from the pinhole fit: the fisheye's own start assumes a field of view of 180 degrees.
void run_fisheye(OpenCvProblem& problem) {
  run_perspective(problem, "pinhole");
  problem.coefficients = cv::Mat::zeros(4, 1, CV_64F);
  problem.rotations.clear();
  problem.translations.clear();
  const int flags = cv::fisheye::CALIB_USE_INTRINSIC_GUESS |
                    cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW;
  cv::fisheye::calibrate(problem.points, problem.pixels, problem.size, problem.camera_matrix,
                         problem.coefficients, problem.rotations, problem.translations, flags,
                         kStop);
}

std::string lens_model_of(const std::string& model) {
  return model == "plumb_bob_k1" ? "plumb_bob" : model;
}

CameraModel camera_from(const OpenCvProblem& problem, const std::string& model) {
  const cv::Mat& K = problem.camera_matrix;
  const Intrinsics k{K.at<double>(0, 0), K.at<double>(1, 1), K.at<double>(0, 2),
                     K.at<double>(1, 2)};
  const std::string lens_model = lens_model_of(model);
  const std::size_t count = distortion_coefficients(make_camera_model(lens_model, k, {})).size();
  const auto* first = problem.coefficients.ptr<double>();
  return make_camera_model(lens_model, k, {first, first + count});
}

/// `vector` is 3 x 1, 1 x 3 or one 3-channel element, of doubles.
Eigen::Vector3d vector_from(const cv::Mat& vector) {
  return Eigen::Map<const Eigen::Vector3d>(vector.ptr<double>());
}

/// Jacobian of a pixel by fx, fy, cx, cy and the first distortion coefficients (the latter by
/// central differences: all models are nearly linear in them).
Eigen::Matrix2Xd camera_jacobian(const CameraModel& camera, const Eigen::Vector3d& p_C,
                                 std::size_t free_coefficients) {
  const Intrinsics k = intrinsics(camera);
  const Eigen::Vector2d uv = project(camera, p_C).value();
  Eigen::Matrix2Xd J(2, 4 + free_coefficients);
  J.leftCols(4) << (uv.x() - k.cx) / k.fx, 0.0, 1.0, 0.0, 0.0, (uv.y() - k.cy) / k.fy, 0.0, 1.0;
  for (std::size_t c = 0; c < free_coefficients; ++c) {
    const auto pixel = [&](double step) {
      auto moved = distortion_coefficients(camera);
      moved[c] += step;
      return project(make_camera_model(lens_model_name(camera), k, moved), p_C).value();
    };
    J.col(4 + c) = (pixel(kCoefficientStep) - pixel(-kCoefficientStep)) / (2.0 * kCoefficientStep);
  }
  return J;
}

/// Information about the camera that one view adds once its pose is eliminated.
Eigen::MatrixXd view_information(const CameraModel& camera, const Pose& X_CG,
                                 const CalibrationView& view, std::size_t free_coefficients) {
  const Eigen::Index rows = 2 * static_cast<Eigen::Index>(view.pixels.size());
  Eigen::MatrixXd J_K(rows, 4 + free_coefficients);
  Eigen::MatrixXd J_CG(rows, 6);
  for (std::size_t i = 0; i < view.pixels.size(); ++i) {
    const Eigen::Vector3d rotated =
        X_CG.linear() * Eigen::Vector3d(view.points_G[i].x(), view.points_G[i].y(), 0.0);
    const Eigen::Vector3d p_C = rotated + X_CG.translation();
    Eigen::Matrix<double, 2, 3> d_uv_d_p;
    project(camera, p_C, &d_uv_d_p);
    J_K.middleRows<2>(2 * i) = camera_jacobian(camera, p_C, free_coefficients);
    J_CG.middleRows<2>(2 * i) << d_uv_d_p, -d_uv_d_p * cross_matrix(rotated);
  }
  const Eigen::MatrixXd mixed = J_CG.transpose() * J_K;
  return J_K.transpose() * J_K - mixed.transpose() * (J_CG.transpose() * J_CG).ldlt().solve(mixed);
}

}  // namespace

std::optional<LensFit> fit_lens(const std::vector<CalibrationView>& views, int width_px,
                                int height_px, const std::string& model) {
  OpenCvProblem problem = opencv_problem(views, {width_px, height_px});
  LensFit fit;
  try {
    if (model == "equidistant") {
      run_fisheye(problem);
    } else {
      run_perspective(problem, model);
    }
    fit.camera = camera_from(problem, model);
  } catch (const cv::Exception&) {
    return std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;  // coefficients that are not finite
  }
  for (std::size_t i = 0; i < views.size(); ++i) {
    Pose X_CG = Pose::Identity();
    X_CG.linear() = rotation_from_vector(vector_from(problem.rotations[i]));
    X_CG.translation() = vector_from(problem.translations[i]);
    const auto residuals = board_residuals(fit.camera, X_CG, views[i].points_G, views[i].pixels);
    if (!residuals) return std::nullopt;
    fit.X_CG.push_back(X_CG);
    fit.view_rms_px.push_back(rms_length(*residuals));
  }
  return fit;
}

std::vector<double> standard_deviations(const LensFit& fit,
                                        const std::vector<CalibrationView>& views,
                                        std::size_t free_coefficients) {
  const Eigen::Index parameters = 4 + static_cast<Eigen::Index>(free_coefficients);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(parameters, parameters);
  double squares = 0.0;
  double freedom = -static_cast<double>(parameters);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double points = static_cast<double>(views[i].pixels.size());
    information += view_information(fit.camera, fit.X_CG[i], views[i], free_coefficients);
    squares += fit.view_rms_px[i] * fit.view_rms_px[i] * points;
    freedom += 2.0 * points - 6.0;
  }
  const Eigen::VectorXd variances =
      information.ldlt().solve(Eigen::MatrixXd::Identity(parameters, parameters)).diagonal() *
      (squares / freedom);
  std::vector<double> deviations(4 + distortion_coefficients(fit.camera).size(), 0.0);
  for (Eigen::Index i = 0; i < parameters; ++i) deviations[i] = std::sqrt(variances[i]);
  return deviations;
}

}  // namespace planar
