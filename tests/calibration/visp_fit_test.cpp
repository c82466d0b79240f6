#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>
#include <opencv2/imgcodecs.hpp>

#include "calibration/board_views.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/calibration/camera_calibration.h"
#include "planar_servo/geometry/lens/lens_models.h"
#include "support/refused.h"
#include "support/shared_data.h"

namespace planar {
namespace {

using test::kIntrinsics;
using test::kNoise_px;
using test::Refused;
using test::views_of_board;

/// Of a fitted parameter; 5 standard deviations happen once in a million.
constexpr double kVispDeviations = 5.0;

/// Root mean square distance between where two cameras see the same rays, over the pixels in which
/// the first one was calibrated.
double projection_difference_px(const CameraCalibration& calibration, const CameraModel& other) {
  constexpr int kSteps = 20;
  const PlaneError& box = calibration.plane_error;
  double squares = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const Eigen::Vector2d share(static_cast<double>(i) / kSteps, static_cast<double>(j) / kSteps);
      const Eigen::Vector2d uv = box.from_px + share.cwiseProduct(box.to_px - box.from_px);
      squares += (project(other, ray(calibration.camera, uv).value()).value() - uv).squaredNorm();
    }
  }
  return std::sqrt(squares / ((kSteps + 1) * (kSteps + 1)));
}

TEST_CASE("ViSP's calibration finds its own lens within its standard deviations") {
  const VispModel truth{kIntrinsics, 0.02, -0.02};
  const CameraCalibration found = calibrate_camera(views_of_board(truth, 10, "visp"));
  const VispModel& camera = *found.camera.as<VispModel>();
  const auto& sigma = found.standard_deviations;
  REQUIRE(sigma.size() == 6);
  CHECK(std::abs(camera.k.fx - truth.k.fx) < kVispDeviations * sigma[0]);
  CHECK(std::abs(camera.k.fy - truth.k.fy) < kVispDeviations * sigma[1]);
  CHECK(std::abs(camera.k.cx - truth.k.cx) < kVispDeviations * sigma[2]);
  CHECK(std::abs(camera.k.cy - truth.k.cy) < kVispDeviations * sigma[3]);
  CHECK(std::abs(camera.kud - truth.kud) < kVispDeviations * sigma[4]);
  CHECK(std::abs(camera.kdu - truth.kdu) < kVispDeviations * sigma[5]);
  CHECK(found.rms_px == Approx(kNoise_px * std::sqrt(2.0)).epsilon(0.1));
  CHECK(found.held_out_rms_px.value() == Approx(kNoise_px * std::sqrt(2.0)).epsilon(0.2));
}

TEST_CASE("ViSP's calibration is as certain of a lens as our own fit with one coefficient") {
  const PlumbBob lens{kIntrinsics, 0.02};
  const auto ours = calibrate_camera(views_of_board(lens, 10, "plumb_bob_k1"));
  const auto theirs = calibrate_camera(views_of_board(lens, 10, "visp"));
  for (std::size_t i = 0; i < 5; ++i) {
    INFO("parameter " << i);
    CHECK(theirs.standard_deviations[i] == Approx(ours.standard_deviations[i]).epsilon(0.1));
  }
}

TEST_CASE("ViSP's calibration projects as our own fit of the same views does") {
  const PlumbBob lens{kIntrinsics, 0.02};
  const auto ours = calibrate_camera(views_of_board(lens, 10, "plumb_bob_k1"));
  const auto theirs = calibrate_camera(views_of_board(lens, 10, "visp"));
  CHECK(projection_difference_px(ours, theirs.camera) < kNoise_px);
}

TEST_CASE("ViSP's calibration leaves the precision of std::cout as it was") {
  const auto before = std::cout.precision();
  calibrate_camera(views_of_board(Pinhole{kIntrinsics}, 4, "visp"));
  CHECK(std::cout.precision() == before);
}

TEST_CASE("More views than ViSP's calibration holds are refused") {
  CHECK_THROWS_MATCHES(calibrate_camera(views_of_board(Pinhole{kIntrinsics}, 257, "visp")),
                       InputError, Refused(Cause::kInvalid, "257 views"));
}

TEST_CASE("ViSP's calibration of the grid36 photographs projects as our own does") {
  const auto folder = test::visp_image("calibration");
  if (!folder) return;
  const Board board{Board::Kind::kCircles, 6, 6, 0.030};
  CalibrationProblem problem;
  for (const char* name : {"grid36-01.pgm", "grid36-02.pgm", "grid36-03.pgm", "grid36-04.pgm"}) {
    const cv::Mat image = cv::imread(*folder / name, cv::IMREAD_GRAYSCALE);
    const BoardSight sight = find_board(image, board);
    problem.views.push_back({name, board_points(board), sight.pixels, sight.dot_areas_px2});
    problem.width_px = image.cols;
    problem.height_px = image.rows;
  }
  problem.model = "plumb_bob_k1";
  const auto ours = calibrate_camera(problem);
  problem.model = "visp";
  const auto theirs = calibrate_camera(problem);
  CHECK(theirs.views.size() == 4);
  CHECK(projection_difference_px(ours, theirs.camera) < ours.rms_px);
  CHECK(theirs.rms_px < 1.05 * ours.rms_px);
  CHECK(theirs.held_out_rms_px.value() < 1.05 * ours.held_out_rms_px.value());
}

}  // namespace
}  // namespace planar
