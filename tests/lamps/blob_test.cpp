#include "planar_servo/lamps/blob.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

TEST_CASE("describe_blob finds area, middle, moments and levels of a patch, however wide") {
  constexpr double kRounded = 1e-9;  // relative
  const cv::Size image_size(3000, 60);
  for (const cv::Rect lit : {cv::Rect(200, 20, 40, 30), cv::Rect(300, 20, 2600, 12)}) {
    cv::Mat image(image_size, CV_8UC1, cv::Scalar(12));
    image(lit) = 200;
    image(cv::Rect(lit.tl(), cv::Size(2, lit.height))) = 255;
    const Blob blob = describe_blob(image, lit, 60);
    const double width = lit.width, height = lit.height;
    CHECK(blob.area_px2 == width * height);
    CHECK(blob.uv_px.x() == Approx(lit.x + 0.5 * (width - 1.0)).epsilon(kRounded));
    CHECK(blob.uv_px.y() == Approx(lit.y + 0.5 * (height - 1.0)).epsilon(kRounded));
    CHECK(blob.second_moments_px2(0, 0) == Approx(width * width / 12.0).epsilon(kRounded));
    CHECK(blob.second_moments_px2(1, 1) == Approx(height * height / 12.0).epsilon(kRounded));
    CHECK(blob.second_moments_px2(0, 1) == Approx(0.0).margin(kRounded * width * width));
    CHECK(blob.level == 200.0);
    CHECK(blob.background == 12.0);
    CHECK(blob.saturated_share == Approx(2.0 / width).epsilon(kRounded));
  }
}

TEST_CASE("describe_blob takes the dark of the box for the surroundings of a lamp without any") {
  cv::Mat image(40, 40, CV_8UC1, cv::Scalar(200));
  const cv::Rect all(0, 0, 40, 40);
  CHECK(describe_blob(image, all, 60).contrast() < 0.0);
  image(cv::Rect(0, 0, 5, 40)) = 12;
  CHECK(describe_blob(image, all, 60).background == 12.0);
}

}  // namespace
}  // namespace planar
