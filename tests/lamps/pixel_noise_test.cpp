#include "planar_servo/lamps/rim/rim_band.h"

#include <catch2/catch.hpp>

#include "support/rendered_lamp.h"

namespace planar {
namespace {

Outline disc(double diameter) {
  Outline outline;
  outline.center = {64.0, 64.0};
  outline.axes *= 0.5 * diameter;
  return outline;
}

PixelNoise noise_of(const test::RenderedLamp& lamp, const test::Sensor& sensor) {
  std::mt19937 random(3);
  cv::Mat scene = test::background({128, 128});
  test::add_lamp(scene, lamp);
  return estimate_noise(test::expose(scene, random, sensor), disc(lamp.diameter_px));
}

TEST_CASE("estimate_noise finds the variance of dark and bright pixels, whatever the gain") {
  // Of about 1000 second differences, whose mean square scatters by about 5 per cent.
  constexpr double kEstimate = 0.2;
  for (const double gain : {5.0, 18.6, 60.0}) {
    const test::Sensor sensor{gain, 0.5};
    const PixelNoise noise = noise_of({{64.0, 64.0}}, sensor);
    for (const double level : {12.0, 100.0, 192.0}) {
      const double truth = level / gain + 0.25 + 1.0 / 12.0;
      CHECK(noise.variance(level) == Approx(truth).epsilon(kEstimate));
    }
  }
}

TEST_CASE("estimate_noise is not misled by a gradient or a clipped lamp") {
  cv::Mat slope(128, 128, CV_32F);
  for (int u = 0; u < slope.cols; ++u) slope.col(u) = 20.0 + u;
  std::mt19937 random(4);
  const PixelNoise noise = estimate_noise(test::expose(slope, random), disc(40.0));
  CHECK(noise.variance(84.0) == Approx(84.0 / 18.6 + 1.0 / 3.0).epsilon(0.2));

  const PixelNoise clipped = noise_of({{64.0, 64.0}, 40.0, 1.0, 0.0, 400.0}, {});
  CHECK(clipped.variance(12.0) == Approx(12.0 / 18.6 + 1.0 / 3.0).epsilon(0.2));
}

TEST_CASE("estimate_noise never says less than rounding makes") {
  const cv::Mat even(128, 128, CV_8UC1, cv::Scalar(12));
  CHECK(estimate_noise(even, disc(40.0)).variance(12.0) == Approx(1.0 / 12.0));
}

}  // namespace
}  // namespace planar
