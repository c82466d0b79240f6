#include "planar_servo/lamps/paper_center.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace planar {
namespace {

// The error on sharp steps is near 0.05 px rms, because the disc consists of pixels.
constexpr double kRms_px = 0.07, kWorst_px = 0.2;

/// A straight step from 20 to 220: bright where n . (p - centre) > offset, exact area by samples.
cv::Mat step_image(double angle, double offset, int centre) {
  constexpr int kSamples = 32;
  cv::Mat image(2 * centre + 1, 2 * centre + 1, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      int bright = 0;
      for (int i = 0; i < kSamples * kSamples; ++i) {
        const double x = u - centre - 0.5 + (i % kSamples + 0.5) / kSamples;
        const double y = v - centre - 0.5 + (i / kSamples + 0.5) / kSamples;
        bright += std::cos(angle) * x + std::sin(angle) * y > offset ? 1 : 0;
      }
      image.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(20.0 + 200.0 * bright / (kSamples * kSamples));
    }
  }
  return image;
}

TEST_CASE("Grey moments find a straight step at any offset and direction") {
  for (const int half_width : {2, 3}) {
    const GreyMoments moments(half_width);
    double sum = 0.0;
    int n = 0;
    for (const double angle : {0.0, 0.4, 1.9, 2.5, 3.5, 5.0}) {
      for (const double offset : {-0.7, -0.45, -0.3, 0.1, 0.25, 0.45, 0.7}) {
        const auto edge = moments.edge(step_image(angle, offset, 6), {6, 6}, 50.0);
        REQUIRE(edge);
        const Eigen::Vector2d n_edge(std::cos(angle), std::sin(angle));
        const double error = (*edge - Eigen::Vector2d(6, 6)).dot(n_edge) - offset;
        CHECK(std::abs(error) < kWorst_px);
        sum += error * error;
        ++n;
      }
    }
    CHECK(std::sqrt(sum / n) < kRms_px);
  }
}

TEST_CASE("Grey moments of a step through the pixel's centre put the edge there exactly") {
  constexpr double kSymmetry_px = 0.005;  // by symmetry; levels are rounded to 1/200 of the step
  const auto edge = GreyMoments(3).edge(step_image(0.0, 0.0, 6), {6, 6}, 50.0);
  REQUIRE(edge);
  CHECK((*edge - Eigen::Vector2d(6, 6)).norm() < kSymmetry_px);
}

TEST_CASE("Grey moments refuse what is no measurable edge") {
  const GreyMoments moments(3);
  const cv::Mat step = step_image(0.3, 0.2, 6);
  CHECK(moments.edge(step, {6, 6}, 150.0));
  SECTION("a step smaller than asked for") {
    CHECK_FALSE(moments.edge(step, {6, 6}, 230.0));
  }
  SECTION("a window that leaves the image") {
    CHECK_FALSE(moments.edge(step, {2, 6}, 50.0));
  }
  SECTION("an edge more than a pixel away") {
    CHECK_FALSE(moments.edge(step, {8, 6}, 50.0));
  }
  SECTION("an even patch") {
    CHECK_FALSE(moments.edge(cv::Mat(13, 13, CV_8UC1, cv::Scalar(90)), {6, 6}, 0.0));
  }
  SECTION("a saturated window") {
    CHECK_FALSE(moments.edge(step + 100, {6, 6}, 50.0));
  }
}

}  // namespace
}  // namespace planar
