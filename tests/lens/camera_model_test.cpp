#include "planar_servo/geometry/lens/lens_models.h"

#include <catch2/catch.hpp>
#include <limits>
#include <set>

#include "planar_servo/base/core/error.h"
#include "support/finite_differences.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

/// Error of a fourth-order difference at the steps below, relative to the Jacobian.
constexpr double kJacobianTolerance = 1e-8;
/// The inverse stops at 1e-13 in normalised units; times the focal length of 5200 px.
constexpr double kRoundTripTolerance_px = 1e-8;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<Eigen::Vector3d> points_in_view() {
  std::vector<Eigen::Vector3d> points;
  for (const double x : {-0.45, -0.2, 0.0, 0.1, 0.47}) {
    for (const double y : {-0.4, 0.0, 0.3}) points.emplace_back(1.1 * x, 1.1 * y, 1.1);
  }
  return points;
}

/// ViSP's two polynomials are separate fits: they are not each other's inverse.
bool undistorts_exactly(const CameraModel& camera) {
  return !camera.as<VispModel>();
}

TEST_CASE("Every lens model has a name of its own and a sample of its own kind") {
  std::set<std::string> names;
  for (const CameraModel& camera : sample_cameras()) {
    CHECK(names.insert(lens_model_name(camera)).second);
    CHECK((camera.as<Pinhole>() != nullptr) == (lens_model_name(camera) == Pinhole::kName));
  }
  CHECK(names.size() == 6);
  for (const CalibrationModel& model : calibration_models())
    CHECK(model.free_coefficients <= distortion_coefficients(model.sample).size());
}

TEST_CASE("The projection's Jacobian agrees with finite differences for every lens model") {
  for (const CameraModel& camera : sample_cameras()) {
    for (const Eigen::Vector3d& p : points_in_view()) {
      INFO(lens_model_name(camera) << " at " << p.transpose());
      Eigen::Matrix<double, 2, 3> J;
      REQUIRE(project(camera, p, &J));
      const auto pixel = [&](const Eigen::VectorXd& q) { return *project(camera, q); };
      CHECK(test::jacobian_mismatch(J, pixel, p, 1e-3) < kJacobianTolerance);
    }
  }
}

TEST_CASE("The ray's Jacobian agrees with finite differences for every lens model") {
  for (const CameraModel& camera : sample_cameras()) {
    for (const Eigen::Vector3d& p : points_in_view()) {
      INFO(lens_model_name(camera) << " at " << p.transpose());
      const Eigen::Vector2d uv = *project(camera, p);
      Eigen::Matrix2d J;
      REQUIRE(ray(camera, uv, &J));
      const auto xy = [&](const Eigen::VectorXd& q) -> Eigen::VectorXd {
        return ray(camera, q)->head<2>();
      };
      CHECK(test::jacobian_mismatch(J, xy, uv, 5.0) < kJacobianTolerance);
    }
  }
}

TEST_CASE("The ray of a projected point passes through the point") {
  for (const CameraModel& camera : sample_cameras()) {
    if (!undistorts_exactly(camera)) continue;
    for (const Eigen::Vector3d& p : points_in_view()) {
      INFO(lens_model_name(camera) << " at " << p.transpose());
      const auto back = ray(camera, *project(camera, p));
      REQUIRE(back);
      CHECK((*back - p / p.z()).norm() * intrinsics(camera).fx < kRoundTripTolerance_px);
    }
  }
}

TEST_CASE("ViSP's two polynomials act one in each direction") {
  const VispModel camera{{100.0, 200.0, 10.0, 20.0}, 0.1, -0.2};
  const Eigen::Vector2d uv = *project(camera, {0.3, 0.4, 1.0});
  CHECK(uv.x() == Approx(10.0 + 100.0 * 0.3 * (1.0 + 0.1 * 0.25)));
  CHECK(uv.y() == Approx(20.0 + 200.0 * 0.4 * (1.0 + 0.1 * 0.25)));
  const Eigen::Vector3d back = *ray(camera, {40.0, 100.0});
  CHECK(back.x() == Approx(0.3 * (1.0 - 0.2 * 0.25)));
  CHECK(back.y() == Approx(0.4 * (1.0 - 0.2 * 0.25)));
}

TEST_CASE("Points behind the camera and absurd numbers have no pixel and no ray") {
  for (const CameraModel& camera : sample_cameras()) {
    INFO(lens_model_name(camera));
    CHECK_FALSE(project(camera, {0.1, 0.1, 0.0}));
    CHECK_FALSE(project(camera, {0.1, 0.1, -1.0}));
    CHECK_FALSE(project(camera, {kNaN, 0.1, 1.0}));
    CHECK_FALSE(project(camera, {0.1, 0.1, kNaN}));
    CHECK_FALSE(project(camera, {0.1, 1e300, 1e-300}));
    CHECK_FALSE(ray(camera, {kNaN, 0.0}));
    CHECK_FALSE(ray(camera, {0.0, std::numeric_limits<double>::infinity()}));
    if (camera.as<Pinhole>() == nullptr) CHECK_FALSE(ray(camera, {1e200, -1e200}));
  }
}

TEST_CASE("A camera is made again from its name, intrinsics and coefficients") {
  for (const CameraModel& camera : sample_cameras()) {
    const CameraModel copy = make_camera_model(lens_model_name(camera), intrinsics(camera),
                                               distortion_coefficients(camera));
    CHECK(lens_model_name(copy) == lens_model_name(camera));
    CHECK(distortion_coefficients(copy) == distortion_coefficients(camera));
    CHECK(*project(copy, {0.2, 0.1, 1.0}) == *project(camera, {0.2, 0.1, 1.0}));
  }
}

TEST_CASE("Missing coefficients are zero, wrong ones are refused by name") {
  const Intrinsics k{500.0, 500.0, 320.0, 240.0};
  CHECK(distortion_coefficients(make_camera_model("plumb_bob", k, {0.1})) ==
        std::vector<double>{0.1, 0.0, 0.0, 0.0, 0.0});
  CHECK_THROWS_MATCHES(make_camera_model("brown", k, {}), InputError,
                       Refused(Cause::kInvalid, "'brown'"));
  CHECK_THROWS_AS(make_camera_model("pinhole", k, {0.1}), InputError);
  CHECK_THROWS_AS(make_camera_model("plumb_bob", k, {kNaN}), InputError);
  std::vector<double> edge_on(14, 0.0);
  edge_on[13] = -1.6;
  CHECK_THROWS_MATCHES(make_camera_model("opencv_14", k, edge_on), InputError,
                       Refused(Cause::kInvalid, "right angle"));
  CHECK_THROWS_AS(make_camera_model("pinhole", Intrinsics{0.0, 1.0, 0.0, 0.0}, {}), InputError);
}

}  // namespace
}  // namespace planar
