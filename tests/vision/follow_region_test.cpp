#include "planar_servo/vision/regions.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

CameraSettings camera_of(int width, int height, int region) {
  CameraSettings camera;
  camera.width_px = width;
  camera.height_px = height;
  camera.follow_region_px = region;
  return camera;
}

TEST_CASE("A region lies about its pixel, and on the sensor near its rim") {
  const CameraSettings camera = camera_of(1000, 800, 200);
  CHECK(follow_region(camera, {500.0, 400.0}) == cv::Rect(400, 300, 200, 200));
  CHECK(follow_region(camera, {10.0, 795.0}) == cv::Rect(0, 600, 200, 200));
}

TEST_CASE("A sensor smaller than the region is taken whole") {
  CHECK(follow_region(camera_of(100, 300, 200), {50.0, 150.0}) == cv::Rect(0, 50, 100, 200));
}

}  // namespace
}  // namespace planar
