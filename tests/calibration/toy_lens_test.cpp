#include <catch2/catch.hpp>
#include <cmath>

#include "calibration/board_views.h"
#include "planar_servo/calibration/camera_calibration.h"
#include "planar_servo/geometry/lens/lens_models.h"
#include "support/finite_differences.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::kIntrinsics;
using test::kNoise_px;
using test::Refused;
using test::views_of_board;

/// The point scaled by `scale`, whose derivative by the point's squared length is `slope`.
lens::Mapped scaled_point(const Eigen::Vector2d& xy, double scale, double slope) {
  return {scale * xy, scale * Eigen::Matrix2d::Identity() + 2.0 * slope * xy * xy.transpose()};
}

/// The division model, which neither OpenCV nor ViSP has [Fitzgibbon 2001]:
/// x = x_d / (1 + lambda r_d^2).
struct DivisionLens {
  static constexpr const char* kName = "division";

  Intrinsics k;
  double lambda{0.0};

  static std::array<lens::Coefficient<DivisionLens>, 1> coefficients() {
    return {{{&DivisionLens::lambda, 10.0, "a division of ten or more"}}};
  }

  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const {
    const double square = 1.0 - 4.0 * lambda * xy.squaredNorm();
    if (!(square > 0.0)) return std::nullopt;
    const double root = std::sqrt(square);
    return scaled_point(xy, 2.0 / (1.0 + root),
                        4.0 * lambda / (root * (1.0 + root) * (1.0 + root)));
  }

  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const {
    const double share = lambda * xy.squaredNorm();
    if (!(share < 1.0) || !(share > -1.0)) return std::nullopt;
    return scaled_point(xy, 1.0 / (1.0 + share), -lambda / ((1.0 + share) * (1.0 + share)));
  }
};

const DivisionLens kDivisionLens{kIntrinsics, -0.25};

/// The lens takes one line.
CalibrationModels models_with_toy() {
  return {{"pinhole", Pinhole{}, 0, 1},
          {"division", DivisionLens{}, 1, 2},
          {"plumb_bob", PlumbBob{}, 5, 3}};
}

TEST_CASE("A toy lens is a camera like any other") {
  const CameraModel camera = kDivisionLens;
  const Eigen::Vector3d p_C(0.2, -0.15, 1.0);
  Eigen::Matrix<double, 2, 3> J;
  const auto uv = project(camera, p_C, &J);
  REQUIRE(uv);
  CHECK((ray(camera, *uv).value() - p_C).norm() < 1e-12);
  const auto pixel = [&](const Eigen::VectorXd& p) { return *project(camera, p); };
  CHECK(test::jacobian_mismatch(J, pixel, p_C, 1e-3) < 1e-8);
  CHECK_THROWS_MATCHES(camera.lens().with(kIntrinsics, {12.0}), InputError,
                       Refused(Cause::kInvalid, "division of ten"));
}

TEST_CASE("A lens of a family that no library has is calibrated as any other") {
  const CameraCalibration found =
      calibrate_camera(views_of_board(kDivisionLens, 10, "division"), {}, models_with_toy());
  const auto* const camera = found.camera.as<DivisionLens>();
  REQUIRE(camera);
  constexpr double kDeviationsOff = 5.0;  // happen once in a million
  const auto& sigma = found.standard_deviations;
  CHECK(std::abs(camera->k.fx - kIntrinsics.fx) < kDeviationsOff * sigma.at(0));
  CHECK(std::abs(camera->k.fy - kIntrinsics.fy) < kDeviationsOff * sigma.at(1));
  CHECK(std::abs(camera->k.cx - kIntrinsics.cx) < kDeviationsOff * sigma.at(2));
  CHECK(std::abs(camera->k.cy - kIntrinsics.cy) < kDeviationsOff * sigma.at(3));
  CHECK(std::abs(camera->lambda - kDivisionLens.lambda) < kDeviationsOff * sigma.at(4));
  CHECK(sigma.at(0) < 5.0);
  CHECK(found.rms_px == Approx(kNoise_px * std::sqrt(2.0)).epsilon(0.1));
  CHECK(found.held_out_rms_px.value() == Approx(kNoise_px * std::sqrt(2.0)).epsilon(0.2));
  CHECK(found.plane_error.mean() > 0.0);
}

TEST_CASE("`auto` takes a toy lens that explains the views and is simple") {
  const auto found =
      calibrate_camera(views_of_board(kDivisionLens, 10, "auto"), {}, models_with_toy());
  CHECK(found.model == "division");
  CHECK(calibration_model_names(models_with_toy()) ==
        std::vector<std::string>{"pinhole", "division", "plumb_bob", "auto"});
}

/// Returns how the focal length and the principal point scatter when views are left out one by one.
Eigen::Array4d scatter_of_refits(const CalibrationProblem& problem) {
  const auto n = static_cast<Eigen::Index>(problem.views.size());
  Eigen::Array<double, 4, Eigen::Dynamic> refits(4, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    CalibrationProblem fewer = problem;
    fewer.views.erase(fewer.views.begin() + i);
    const Intrinsics k = intrinsics(calibrate_camera(fewer).camera);
    refits.col(i) << k.fx, k.fy, k.cx, k.cy;
  }
  refits.colwise() -= refits.rowwise().mean().eval();
  const double views = static_cast<double>(n);
  return ((views - 1.0) / views * refits.square().rowwise().sum()).sqrt();
}

TEST_CASE("Deviations of a lens of another kind are what the camera scatters over the views") {
  // A lens that one coefficient of the plumb-bob follows to a tenth of a pixel only.
  const DivisionLens strong{kIntrinsics, -0.6};
  const CalibrationProblem problem = views_of_board(strong, 12, "plumb_bob_k1");
  const CameraCalibration found = calibrate_camera(problem);
  CHECK(found.rms_px > 2.0 * kNoise_px * std::sqrt(2.0));
  const Eigen::Array4d scatter = scatter_of_refits(problem);
  for (Eigen::Index i = 0; i < 4; ++i) {
    INFO("parameter " << i);
    CHECK(found.standard_deviations.at(static_cast<std::size_t>(i)) > 0.7 * scatter[i]);
  }
}

}  // namespace
}  // namespace planar
