#include <catch2/catch.hpp>
#include <opencv2/calib3d.hpp>

#include "planar_servo/geometry/lens/lens_models.h"

namespace planar {
namespace {

/// Rounding of a few products of numbers near 5000.
constexpr double kRounding_px = 1e-9;

cv::Matx33d camera_matrix(const Intrinsics& k) {
  return {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
}

cv::Point2d opencv_projection(const CameraModel& camera, const cv::Point3d& p) {
  const std::vector<cv::Point3d> points{p};
  const cv::Vec3d zero;
  std::vector<cv::Point2d> pixels;
  const auto coefficients = distortion_coefficients(camera);
  const cv::Matx33d K = camera_matrix(intrinsics(camera));
  if (camera.as<KannalaBrandt>()) {
    cv::fisheye::projectPoints(points, pixels, zero, zero, K, coefficients);
  } else {
    cv::projectPoints(points, zero, zero, K, coefficients, pixels);
  }
  return pixels.front();
}

TEST_CASE("Every model shared with OpenCV projects to OpenCV's pixel") {
  for (const CameraModel& camera : sample_cameras()) {
    if (camera.as<VispModel>()) continue;
    for (const double x : {-0.4, -0.1, 0.0, 0.3}) {
      for (const double y : {-0.35, 0.0, 0.25}) {
        INFO(lens_model_name(camera) << " at " << x << ", " << y);
        const auto ours = project(camera, {x, y, 1.05});
        REQUIRE(ours);
        const cv::Point2d theirs = opencv_projection(camera, {x, y, 1.05});
        CHECK((*ours - Eigen::Vector2d(theirs.x, theirs.y)).norm() < kRounding_px);
      }
    }
  }
}

}  // namespace
}  // namespace planar
