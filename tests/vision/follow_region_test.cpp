#include "planar_servo/loop/vision/lamp_tip_sensor.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

TEST_CASE("A region lies about its pixel, and on the sensor near its rim") {
  const cv::Size sensor_px(1000, 800);
  CHECK(follow_region(sensor_px, 200, {500.0, 400.0}) == cv::Rect(400, 300, 200, 200));
  CHECK(follow_region(sensor_px, 200, {10.0, 795.0}) == cv::Rect(0, 600, 200, 200));
}

TEST_CASE("A sensor smaller than the region is taken whole") {
  CHECK(follow_region({100, 300}, 200, {50.0, 150.0}) == cv::Rect(0, 50, 100, 200));
}

}  // namespace
}  // namespace planar
