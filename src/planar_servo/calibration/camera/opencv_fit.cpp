#include "planar_servo/calibration/camera/opencv_fit.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>

#include "planar_servo/calibration/board/board_pose.h"
#include "planar_servo/calibration/camera/fit_information.h"
#include "planar_servo/core/error.h"

namespace planar {
namespace {

constexpr int kIterations = 60;
constexpr int kFitRounds = 10;
constexpr double kRelativeChange = 1e-10;
/// A fit stands still when one more step would move its parameters by less than this share of their
/// uncertainty, which makes their error larger by an eighth at most. Where parameters trade off, as
/// in the rational model, OpenCV creeps on for thousands of iterations below that.
constexpr double kStandsStill = 0.5;
/// Noise of a pixel coordinate that OpenCV's rounding to single precision may cause.
constexpr double kSinglePrecision_px = 1e-3;

/// Holds the views as OpenCV takes them, and what it returns.
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

/// Returns the views in the precision in which OpenCV has them.
std::vector<CalibrationView> single_precision(std::vector<CalibrationView> views) {
  for (CalibrationView& view : views) {
    for (Eigen::Vector2d& p : view.points_G) p = p.cast<float>().cast<double>();
    for (Eigen::Vector2d& uv : view.pixels) uv = uv.cast<float>().cast<double>();
  }
  return views;
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

void run_perspective(OpenCvProblem& problem, int flags) {
  cv::calibrateCamera(problem.points, problem.pixels, problem.size, problem.camera_matrix,
                      problem.coefficients, problem.rotations, problem.translations, flags, kStop);
}

void run_fisheye(OpenCvProblem& problem) {
  problem.rotations.clear();
  problem.translations.clear();
  const int flags = cv::fisheye::CALIB_USE_INTRINSIC_GUESS |
                    cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW;
  cv::fisheye::calibrate(problem.points, problem.pixels, problem.size, problem.camera_matrix,
                         problem.coefficients, problem.rotations, problem.translations, flags,
                         kStop);
}

void run(OpenCvProblem& problem, const std::string& model, bool is_first) {
  if (model != "equidistant") {
    run_perspective(problem, flags_of(model) | (is_first ? 0 : cv::CALIB_USE_INTRINSIC_GUESS));
    return;
  }
  if (is_first) {
    // This starts from the pinhole fit, because the fisheye's own start assumes a field of view of
    // 180 degrees.
    run_perspective(problem, flags_of("pinhole"));
    problem.coefficients = cv::Mat::zeros(4, 1, CV_64F);
  }
  run_fisheye(problem);
}

CameraModel camera_from(const OpenCvProblem& problem, const std::string& lens) {
  const cv::Mat& K = problem.camera_matrix;
  const Intrinsics k{K.at<double>(0, 0), K.at<double>(1, 1), K.at<double>(0, 2),
                     K.at<double>(1, 2)};
  const std::size_t count = distortion_coefficients(make_camera_model(lens, k, {})).size();
  const auto* first = problem.coefficients.ptr<double>();
  return make_camera_model(lens, k, {first, first + count});
}

/// Returns the three doubles of `vector`, which is 3 x 1, 1 x 3 or one 3-channel element.
Eigen::Vector3d vector_from(const cv::Mat& vector) {
  return Eigen::Map<const Eigen::Vector3d>(vector.ptr<double>());
}

LensFit fit_from(const OpenCvProblem& problem, const std::string& lens) {
  LensFit fit;
  fit.camera = camera_from(problem, lens);
  for (std::size_t i = 0; i < problem.rotations.size(); ++i) {
    Pose& X_CG = fit.X_CG.emplace_back(Pose::Identity());
    X_CG.linear() = rotation_from_vector(vector_from(problem.rotations[i]));
    X_CG.translation() = vector_from(problem.translations[i]);
  }
  return fit;
}

/// Returns whether one more step would move the parameters by less than kStandsStill of their
/// uncertainty. A step as large as the uncertainty lowers the sum of squares by the variance times
/// the number of parameters.
bool stands_still(const FitInformation& information) {
  const double variance = std::max(information.squares / information.freedom,
                                   kSinglePrecision_px * kSinglePrecision_px);
  return information.decrease <= kStandsStill * kStandsStill * information.parameters * variance;
}

}  // namespace

std::optional<LensFit> fit_by_opencv(const std::vector<CalibrationView>& views, int width_px,
                                     int height_px, const FitModel& model) {
  const std::vector<CalibrationView> seen = single_precision(views);
  OpenCvProblem problem = opencv_problem(views, {width_px, height_px});
  std::optional<LensFit> fit;
  try {
    for (int round = 0; round < kFitRounds; ++round) {
      run(problem, model.name, round == 0);
      LensFit next = fit_from(problem, model.lens);
      const auto information = fit_information(next, seen, model.free_coefficients);
      if (!information) break;
      next.converged = stands_still(*information);
      fit = std::move(next);
      if (fit->converged) break;
    }
  } catch (const cv::Exception&) {  // how OpenCV refuses views
  } catch (const InputError&) {     // coefficients that are not finite
  }
  return fit;
}

}  // namespace planar
