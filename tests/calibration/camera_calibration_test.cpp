#include "planar_servo/calibration/camera_calibration.h"

#include <catch2/catch.hpp>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "calibration/board_image.h"
#include "calibration/board_views.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/geometry/lens/lens_models.h"
#include "support/refused.h"
#include "support/shared_data.h"

namespace planar {
namespace {

using test::kBoard;
using test::kIntrinsics;
using test::kNoise_px;
using test::Refused;
using test::views_of_board;

/// Of a fitted parameter; 5 standard deviations happen once in a million.
constexpr double kDeviations = 5.0;

void check_intrinsics(const CameraCalibration& found, const Intrinsics& truth) {
  const Intrinsics k = intrinsics(found.camera);
  const auto& sigma = found.standard_deviations;
  CHECK(std::abs(k.fx - truth.fx) < kDeviations * sigma[0]);
  CHECK(std::abs(k.fy - truth.fy) < kDeviations * sigma[1]);
  CHECK(std::abs(k.cx - truth.cx) < kDeviations * sigma[2]);
  CHECK(std::abs(k.cy - truth.cy) < kDeviations * sigma[3]);
  CHECK(sigma[0] < 5.0);
}

TEST_CASE("Each model's own camera is found within its standard deviations") {
  const std::vector<std::pair<std::string, CameraModel>> cameras{
      {"pinhole", Pinhole{kIntrinsics}},
      {"plumb_bob_k1", PlumbBob{kIntrinsics, -0.15}},
      {"plumb_bob", PlumbBob{kIntrinsics, -0.2, 0.08, 1e-3, -5e-4, 0.02}},
      {"equidistant", KannalaBrandt{kIntrinsics, 0.02, -0.01, 0.005, 0.0}}};
  for (const auto& [model, camera] : cameras) {
    INFO(model);
    const CameraCalibration found = calibrate_camera(views_of_board(camera, 10, model));
    check_intrinsics(found, kIntrinsics);
    CHECK(found.rms_px == Approx(kNoise_px * std::sqrt(2.0)).epsilon(0.1));
    CHECK(found.held_out_rms_px.value() == Approx(kNoise_px * std::sqrt(2.0)).epsilon(0.2));
    CHECK(found.rejected.empty());
    CHECK(found.views.size() == 10);
    const auto truth = distortion_coefficients(camera);
    const auto coefficients = distortion_coefficients(found.camera);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const double sigma = found.standard_deviations[4 + i];
      CHECK(std::abs(coefficients[i] - truth[i]) <= kDeviations * sigma);
    }
  }
}

/// Returns the rms of the errors of fx, fy, cx and cy over several calibrations, in the deviations
/// that each states.
double standardised_rms(const CameraModel& camera, const std::string& model,
                        unsigned calibrations) {
  double sum = 0.0;
  for (unsigned seed = 0; seed < calibrations; ++seed) {
    const auto found =
        calibrate_camera(views_of_board(camera, 12, model, 0.0, kNoise_px, 100 + seed));
    const Intrinsics k = intrinsics(found.camera);
    const Eigen::Array4d off(k.fx - kIntrinsics.fx, k.fy - kIntrinsics.fy, k.cx - kIntrinsics.cx,
                             k.cy - kIntrinsics.cy);
    const Eigen::Map<const Eigen::Array4d> sigma(found.standard_deviations.data());
    sum += (off / sigma).square().mean() / calibrations;
  }
  return std::sqrt(sum);
}

void check_stated(const CameraModel& camera, const std::string& model, unsigned calibrations) {
  INFO(model);
  const double rms = standardised_rms(camera, model, calibrations);
  CAPTURE(rms);
  CHECK(rms > 0.7);
  CHECK(rms < 1.4);
}

const CameraModel kRichLens = PlumbBob{kIntrinsics, -0.2, 0.08, 1e-3, -5e-4, 0.02};

TEST_CASE("Errors of a calibration are as large as the deviations that it states") {
  check_stated(kRichLens, "plumb_bob", 30);
}

// Some minutes; run by its name or by [slow].
TEST_CASE("Over 50 calibrations errors are as large as the stated deviations", "[.slow]") {
  check_stated(kRichLens, "plumb_bob", 50);
  check_stated(KannalaBrandt{kIntrinsics, 0.02, -0.01, 0.005, 0.0}, "equidistant", 50);
  check_stated(PlumbBob{kIntrinsics, -0.15}, "auto", 50);
}

TEST_CASE("The rational model follows a lens of its kind, whatever its coefficients trade off") {
  const CameraModel truth = Rational{kIntrinsics, 0.3, 0.02, -2e-4, 5e-4, 0.001, 0.42, 0.06, 0.002};
  const auto found = calibrate_camera(views_of_board(truth, 6, "rational_polynomial"));
  CHECK(found.rms_px == Approx(kNoise_px * std::sqrt(2.0)).epsilon(0.1));
}

/// A sensor tilted by some 4 degrees: without prism and tilt a quarter of a pixel rms is left.
const OpenCv14 kTiltedLens{{kIntrinsics, 0.3, 0.02, -2e-4, 5e-4, 0.001, 0.42, 0.06, 0.002},
                           0.01,
                           -0.004,
                           -0.008,
                           0.003,
                           0.06,
                           -0.04};

TEST_CASE("opencv_14 follows a thin prism and a tilted sensor, the rational model does not") {
  const auto found = calibrate_camera(views_of_board(kTiltedLens, 10, "opencv_14"));
  CHECK(found.rms_px == Approx(kNoise_px * std::sqrt(2.0)).epsilon(0.1));
  CHECK(found.held_out_rms_px.value() == Approx(kNoise_px * std::sqrt(2.0)).epsilon(0.2));
  CHECK(found.standard_deviations.size() == 4 + distortion_coefficients(kTiltedLens).size());
  const auto rational = calibrate_camera(views_of_board(kTiltedLens, 10, "rational_polynomial"));
  CHECK(rational.rms_px > 2.0 * found.rms_px);
}

TEST_CASE("opencv_14 predicts views of a lens without prism and tilt as well as the rational one") {
  // Six parameters more on ten views of 63 points; by their number alone 0.5 %.
  constexpr double kOfNoise = 0.03;
  const Rational lens = kTiltedLens;
  const auto rational = calibrate_camera(views_of_board(lens, 10, "rational_polynomial"));
  const auto found = calibrate_camera(views_of_board(lens, 10, "opencv_14"));
  CHECK(found.held_out_rms_px.value() < (1.0 + kOfNoise) * rational.held_out_rms_px.value());
}

std::vector<double> numbers_of(const CameraModel& camera) {
  const Intrinsics k = intrinsics(camera);
  std::vector<double> numbers{k.fx, k.fy, k.cx, k.cy};
  for (const double coefficient : distortion_coefficients(camera)) numbers.push_back(coefficient);
  return numbers;
}

TEST_CASE("Deviations that are stated hold, and none is stated of terms that trade off") {
  const std::pair<std::string, CameraModel> cameras[] = {
      {"rational_polynomial", Rational(kTiltedLens)}, {"opencv_14", kTiltedLens}};
  for (const auto& [model, camera] : cameras) {
    INFO(model);
    CalibrationProblem problem = views_of_board(camera, 12, model, 0.0, kNoise_px, 100);
    problem.leaves_views_out = false;
    const CameraCalibration found = calibrate_camera(problem);
    const std::vector<double> truth = numbers_of(camera), fitted = numbers_of(found.camera);
    const std::vector<double>& sigma = found.standard_deviations;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      CAPTURE(i, sigma[i]);
      CHECK((std::isnan(sigma[i]) || std::abs(fitted[i] - truth[i]) <= kDeviations * sigma[i]));
    }
    CHECK(std::isnan(sigma[4]));                            // k1, which k4 makes up for
    CHECK(std::isnan(sigma[2]) == (model == "opencv_14"));  // cx, which the tilt makes up for
  }
}

TEST_CASE("Pictures through a lens with prism and tilt calibrate to a hundredth of a pixel") {
  constexpr double kDotDiameter = 0.018;
  constexpr double kCentreError_px = 0.02;  // of 8-bit grey levels without noise
  OpenCv14 camera = kTiltedLens;
  camera.k = test::small_camera().k;
  CalibrationProblem problem;
  problem.width_px = 640;
  problem.height_px = 480;
  problem.model = "opencv_14";
  for (int i = 0; i < 8; ++i) {
    const Pose X_CG = test::board_before_camera(kBoard, 0.40 + 0.02 * (i % 3),
                                                0.25 + 0.05 * (i % 5), 1.3 * i, 0.2 * i);
    const BoardSight sight =
        find_board(test::picture_of_dots(camera, kBoard, kDotDiameter, X_CG), kBoard);
    problem.views.push_back(
        {"view" + std::to_string(i), board_points(kBoard), sight.pixels, sight.dot_areas_px2});
  }
  const auto found = calibrate_camera(problem);
  CHECK(found.rejected.empty());
  CHECK(found.held_out_rms_px.value() < kCentreError_px);
  problem.model = "plumb_bob";
  CHECK(calibrate_camera(problem).held_out_rms_px.value() > 2.0 * kCentreError_px);
}

TEST_CASE("Dots' eccentricity, which would pull the focal length, is removed") {
  constexpr double kDiameter = 0.026;
  // Single precision in OpenCV's interface: 6e-5 px at 1000 px.
  constexpr double kFocalTolerance_px = 0.02;
  const PlumbBob truth{kIntrinsics, -0.15};
  CalibrationProblem problem = views_of_board(truth, 10, "plumb_bob_k1", kDiameter, 1e-9);
  const CameraCalibration corrected = calibrate_camera(problem);
  CHECK(std::abs(intrinsics(corrected.camera).fx - kIntrinsics.fx) < kFocalTolerance_px);
  CHECK(corrected.dot_diameter == Approx(kDiameter).epsilon(1e-2));
  for (CalibrationView& view : problem.views) view.dot_areas_px2.clear();
  const CameraCalibration biased = calibrate_camera(problem);
  CHECK(std::abs(intrinsics(biased.camera).fx - kIntrinsics.fx) > 10.0 * kFocalTolerance_px);
}

TEST_CASE("A view with a grossly wrong dot is left out by name") {
  CalibrationProblem problem = views_of_board(PlumbBob{kIntrinsics, -0.15}, 8, "plumb_bob_k1");
  problem.views[3].pixels[20] += Eigen::Vector2d(12.0, -9.0);
  const CameraCalibration found = calibrate_camera(problem);
  REQUIRE(found.rejected.size() == 1);
  CHECK(found.rejected[0].id == "view3");
  CHECK_THAT(found.rejected[0].reason, Catch::Contains("px rms off"));
  check_intrinsics(found, kIntrinsics);
}

TEST_CASE("`auto` takes the simplest model that predicts held-out views as well as any") {
  CHECK(calibrate_camera(views_of_board(Pinhole{kIntrinsics}, 10, "auto")).model == "pinhole");
  CHECK(calibrate_camera(views_of_board(PlumbBob{kIntrinsics, -0.15}, 10, "auto")).model ==
        "plumb_bob_k1");
  const CameraModel rich = PlumbBob{kIntrinsics, -0.2, 0.08, 3e-3, -2e-3, 0.02};
  CHECK(calibrate_camera(views_of_board(rich, 10, "auto")).model == "plumb_bob");
}

TEST_CASE("Too few views, unknown models and numbers that are not finite are refused") {
  const PlumbBob camera{kIntrinsics, -0.15};
  CHECK_THROWS_MATCHES(calibrate_camera(views_of_board(camera, 2, "pinhole")), InputError,
                       Refused(Cause::kInsufficient, "2 usable"));
  CHECK_THROWS_MATCHES(calibrate_camera(views_of_board(camera, 5, "brown")), InputError,
                       Refused(Cause::kInvalid, "'brown'"));
  CalibrationProblem broken = views_of_board(camera, 5, "pinhole");
  broken.views[2].pixels[0].x() = std::numeric_limits<double>::quiet_NaN();
  broken.views[4].points_G.pop_back();
  CHECK_THROWS_MATCHES(calibrate_camera(broken), InputError, Refused(Cause::kInvalid, "view2"));
  CHECK_THROWS_MATCHES(calibrate_camera(broken), InputError, Refused(Cause::kInvalid, "view4"));
}

TEST_CASE("A board's pose is found from its pixels through any lens") {
  const CameraModel camera = PlumbBob{kIntrinsics, -0.2, 0.08, 1e-3, -5e-4, 0.02};
  const Pose X_CG = test::board_before_camera(kBoard, 0.6, 0.3, 0.7, 1.1);
  const auto points = board_points(kBoard);
  std::vector<Eigen::Vector2d> pixels;
  pixels.reserve(points.size());
  for (const auto& p : points) {
    pixels.push_back(*project(camera, X_CG * Eigen::Vector3d(p.x(), p.y(), 0.0)));
  }
  const auto found = estimate_board_pose(camera, points, pixels);
  REQUIRE(found);
  // The iteration stops at a relative change of 1e-7 or so.
  CHECK(found->X_CG.isApprox(X_CG, 1e-6));
  CHECK(found->rms_px < 1e-3);
  CHECK_FALSE(estimate_board_pose(camera, {{0, 0}, {1, 0}, {0, 1}}, {{0, 0}, {9, 0}, {0, 9}}));
  pixels[0].x() = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(estimate_board_pose(camera, points, pixels));
  CHECK_THROWS_AS(estimate_board_pose(camera, points, {}), std::invalid_argument);
}

CalibrationProblem problem_from_images(const std::filesystem::path& folder,
                                       const std::string& extension, const Board& board) {
  CalibrationProblem problem;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != extension) continue;
    const cv::Mat image = cv::imread(entry.path(), cv::IMREAD_GRAYSCALE);
    const BoardSight sight = find_board(image, board);
    problem.views.push_back(
        {entry.path().filename(), board_points(board), sight.pixels, sight.dot_areas_px2});
    problem.width_px = image.cols;
    problem.height_px = image.rows;
  }
  return problem;
}

TEST_CASE("ViSP's photographs give the camera that ViSP documents") {
  const auto folder = test::shared_data("circle_grids/visp");
  if (!folder) return;
  const Board board{Board::Kind::kCircles, 6, 6, 0.034};
  const auto found = calibrate_camera(problem_from_images(*folder, ".jpg", board));
  const Intrinsics k = intrinsics(found.camera);
  constexpr double kTolerance_px = 2.0;  // just above one standard deviation of fx
  CHECK(k.fx == Approx(272.3969).margin(kTolerance_px));
  CHECK(k.fy == Approx(268.6672).margin(kTolerance_px));
  CHECK(k.cx == Approx(163.1810).margin(kTolerance_px));
  CHECK(k.cy == Approx(112.9660).margin(kTolerance_px));
  CHECK(found.rms_px < 0.30090);
}

TEST_CASE(
    "Views that do not tell which lens it is widen the principal point until it covers both") {
  const auto folder = test::shared_data("circle_grids/rct");
  if (!folder) return;
  const Board board{Board::Kind::kCircles, 10, 10, 0.0254};
  CalibrationProblem problem = problem_from_images(*folder, ".png", board);
  problem.model = "auto";
  const CameraCalibration found = calibrate_camera(problem);
  constexpr double kPublished_px = 226.2;  // by k1 k2 p1 p2 k3 on 15 such pictures
  CHECK(std::abs(intrinsics(found.camera).cy - kPublished_px) < 2.0 * found.standard_deviations[3]);
  CHECK(found.standard_deviations[3] < 30.0);
}

TEST_CASE("The grid36 photographs give the camera that vpCalibration finds") {
  const auto folder = test::visp_image("calibration");
  if (!folder) return;
  const Board board{Board::Kind::kCircles, 6, 6, 0.030};
  const auto found = calibrate_camera(problem_from_images(*folder, ".pgm", board));
  const Intrinsics k = intrinsics(found.camera);
  constexpr double kTolerance_px = 2.0;
  CHECK(k.fx == Approx(550.7).margin(kTolerance_px));
  CHECK(k.fy == Approx(543.0).margin(kTolerance_px));
  CHECK(k.cx == Approx(309.2).margin(kTolerance_px));
  CHECK(k.cy == Approx(245.6).margin(kTolerance_px));
  CHECK(found.rms_px < 0.283);
}

}  // namespace
}  // namespace planar
