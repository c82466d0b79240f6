#include "planar_servo/geometry/lens/workplane.h"
#include "planar_servo/geometry/lens/lens_models.h"

#include <catch2/catch.hpp>
#include <limits>

#include "support/finite_differences.h"

namespace planar {
namespace {

/// Error of a fourth-order difference at the steps below, relative to the Jacobian.
constexpr double kPlaneTolerance = 1e-8;
/// 1e-8 px of the lens' inverse at 0.2 mm/px.
constexpr double kRoundTripTolerance_m = 1e-11;

/// 1.2 m above the plane, looking down, tilted by 3 degrees and turned by 20.
Pose camera_above() {
  Pose X_WC = Pose::Identity();
  X_WC.translation() << 0.03, -0.05, 1.2;
  X_WC.linear() = (Eigen::AngleAxisd(0.35, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(3.14159 + 0.05, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  return X_WC;
}

TEST_CASE("A point of the plane is found again from its pixel") {
  for (const CameraModel& camera : sample_cameras()) {
    if (camera.as<VispModel>()) continue;  // two separate fits, no inverse
    const Workplane plane(camera, camera_above());
    for (const double x : {-0.4, 0.0, 0.3}) {
      const Eigen::Vector2d p_W(x, 0.2 - 0.5 * x);
      const auto uv = plane.pixel_from_plane(p_W);
      REQUIRE(uv);
      const auto back = plane.plane_from_pixel(*uv);
      REQUIRE(back);
      CHECK((*back - p_W).norm() < kRoundTripTolerance_m);
    }
  }
}

TEST_CASE("The workplane's Jacobians agree with finite differences") {
  for (const CameraModel& camera : sample_cameras()) {
    INFO(lens_model_name(camera));
    const Workplane plane(camera, camera_above());
    const Eigen::Vector2d p_W(-0.31, 0.22);
    Eigen::Matrix2d d_uv_d_p;
    Eigen::Matrix2d d_p_d_uv;
    const Eigen::Vector2d uv = *plane.pixel_from_plane(p_W, &d_uv_d_p);
    REQUIRE(plane.plane_from_pixel(uv, &d_p_d_uv));
    const auto pixel = [&](const Eigen::VectorXd& p) { return *plane.pixel_from_plane(p); };
    const auto point = [&](const Eigen::VectorXd& p) { return *plane.plane_from_pixel(p); };
    CHECK(test::jacobian_mismatch(d_uv_d_p, pixel, p_W, 1e-3) < kPlaneTolerance);
    CHECK(test::jacobian_mismatch(d_p_d_uv, point, uv, 5.0) < kPlaneTolerance);
  }
}

TEST_CASE("Rays along the plane or away from it meet nothing") {
  const CameraModel camera = Pinhole{{1000.0, 1000.0, 500.0, 500.0}};
  Pose X_WC = Pose::Identity();
  X_WC.translation().z() = 1.0;  // looking up, away from the plane
  CHECK_FALSE(Workplane(camera, X_WC).plane_from_pixel({500.0, 500.0}));
  CHECK_FALSE(Workplane(camera, X_WC).pixel_from_plane({0.0, 0.0}));
  X_WC.linear() = Eigen::AngleAxisd(3.14159265358979 / 2, Eigen::Vector3d::UnitX()).matrix();
  CHECK_FALSE(Workplane(camera, X_WC).plane_from_pixel({500.0, 600.0}));
  CHECK_FALSE(
      Workplane(camera, X_WC).plane_from_pixel({std::numeric_limits<double>::quiet_NaN(), 0.0}));
}

}  // namespace
}  // namespace planar
