#include "planar_servo/console/picture_watch.h"

#include <catch2/catch.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

namespace planar {
namespace {

constexpr double kJpegLevels = 8.0;  // by which a JPEG's grey levels may differ

cv::Mat decoded(const Pictures::Jpeg& jpeg) {
  REQUIRE(jpeg.bytes);
  const std::vector<char> bytes(jpeg.bytes->begin(), jpeg.bytes->end());
  return cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
}

Frame frame_of(const cv::Rect& region_px, int level) {
  return {cv::Mat(region_px.size(), CV_8UC1, cv::Scalar(level)), region_px, 0.0, 0};
}

TEST_CASE("A whole frame is shown scaled, and encoded once for all readers") {
  Pictures pictures({2560, 1280});
  pictures.take(frame_of({0, 0, 2560, 1280}, 100));
  const Pictures::Jpeg first = pictures.whole();
  CHECK(decoded(first).size() == cv::Size(1280, 640));
  CHECK(pictures.whole().bytes == first.bytes);
  pictures.take(frame_of({0, 0, 2560, 1280}, 100));
  CHECK(pictures.whole().bytes != first.bytes);
  CHECK(pictures.whole().number == first.number + 1);
}

TEST_CASE("A region stands bright in the darkened picture before it") {
  Pictures pictures({640, 480});
  pictures.take(frame_of({0, 0, 640, 480}, 200));
  pictures.take(frame_of({320, 240, 160, 160}, 200));
  CHECK(decoded(pictures.whole()).at<unsigned char>(320, 400) == Approx(200.0).margin(kJpegLevels));
  pictures.take(frame_of({320, 240, 160, 160}, 200));
  const cv::Mat image = decoded(pictures.whole());
  CHECK(image.at<unsigned char>(320, 400) == Approx(200.0).margin(kJpegLevels));
  CHECK(image.at<unsigned char>(100, 100) == Approx(100.0).margin(kJpegLevels));
}

TEST_CASE("What is seen stands at its place in a picture of any scale") {
  for (const cv::Size& sensor_px :
       {cv::Size(5120, 5120), cv::Size(5472, 3648), cv::Size(4097, 3001)}) {
    Frame frame = frame_of({{}, sensor_px}, 0);
    frame.image(cv::Rect({}, sensor_px / 4)) = 200;
    Pictures pictures(sensor_px);
    pictures.take(frame);
    const cv::Mat image = decoded(pictures.whole());
    INFO(sensor_px);
    CHECK(image.cols == Pictures::kMostWidth_px);
    CHECK(cv::mean(image)[0] == Approx(200.0 / 16.0).epsilon(0.01));
    CHECK(image.at<unsigned char>(image.rows / 4 - 8, image.cols / 4 - 8) ==
          Approx(200.0).margin(kJpegLevels));
    CHECK(image.at<unsigned char>(image.rows / 4 + 8, image.cols / 4 + 8) ==
          Approx(0.0).margin(kJpegLevels));
  }
}

TEST_CASE("A lamp at the sensor's edge is shown as far as it was seen") {
  Pictures pictures({640, 480});
  CHECK_FALSE(pictures.lamp(0).bytes);
  pictures.take(frame_of({0, 0, 640, 480}, 200));
  CHECK_FALSE(pictures.lamp(0).bytes);
  pictures.aim({Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(-1000.0, 5000.0)});
  const cv::Mat corner = decoded(pictures.lamp(0));
  CHECK(corner.size() == cv::Size(Pictures::kLampSide_px, Pictures::kLampSide_px));
  CHECK(corner.at<unsigned char>(120, 120) == Approx(200.0).margin(kJpegLevels));
  CHECK(corner.at<unsigned char>(20, 20) == Approx(0.0).margin(kJpegLevels));
  CHECK(cv::countNonZero(decoded(pictures.lamp(1))) == 0);
}

}  // namespace
}  // namespace planar
