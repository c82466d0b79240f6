#include "planar_servo/lamps/rim/rim_band.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace planar {
namespace {

cv::Mat noise_image(const cv::Size& size) {
  cv::Mat image(size, CV_8UC1);
  cv::RNG random(5);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  image.setTo(255, image > 180);
  return image;
}

TEST_CASE("RimBand interpolates a plane exactly, waves included") {
  constexpr float kSinglePrecision = 2e-4f;
  cv::Mat image(100, 100, CV_8UC1);
  for (int v = 0; v < 100; ++v) {
    for (int u = 0; u < 100; ++u) image.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(u + v);
  }
  Outline outline;
  outline.center = {48.3, 51.7};
  outline.axes << 20.0, 2.0, 2.0, 15.0;
  outline.waves[0] = 0.7;
  RimBand band;
  band.sample(image, outline, 60, -5.0, 4.0);
  const PerNormal wave = band.normals.waves(outline);
  for (int k = 0; k < band.normals.count(); ++k) {
    for (int j = 0; j < RimBand::kPlaces; ++j) {
      const Eigen::Vector2d p = band.normals.foot.col(k) +
                                (wave[k] + band.distance_px[j]) * band.normals.direction.col(k);
      CHECK(band.level(j, k) == Approx(p.sum()).margin(kSinglePrecision));
    }
  }
}

TEST_CASE("sample_line_fast gives the same bits as sample_line") {
  if (!has_fast_lines()) {
    WARN("skipped: this processor has no AVX2");
    return;
  }
  const cv::Mat image = noise_image({90, 70});
  std::mt19937 random(6);
  std::uniform_real_distribution<float> u(24.0f, 65.0f), v(24.0f, 45.0f), step(-1.2f, 1.2f);
  for (int i = 0; i < 200; ++i) {
    const BandLine line{u(random), v(random), step(random), step(random), 0.3f, 0.7f};
    float level[2][RimBand::kPlaces], blur[2][RimBand::kPlaces];
    sample_line(image, line, level[0], blur[0]);
    sample_line_fast(image, line, level[1], blur[1]);
    for (int j = 0; j < RimBand::kPlaces; ++j) {
      CHECK(level[0][j] == level[1][j]);
      CHECK(blur[0][j] == blur[1][j]);
    }
  }
}

TEST_CASE("RimBand continues with the outermost pixels beyond the image") {
  const cv::Mat image(40, 40, CV_8UC1, cv::Scalar(77));
  Outline outline;
  outline.center = {2.0, 39.0};
  outline.axes *= 10.0;
  RimBand band;
  band.sample(image, outline, 40, -6.0, 6.0);
  CHECK((band.level.array() - 77.0f).abs().maxCoeff() < 1e-4f);
}

TEST_CASE("RimBand marks a sample that is mostly of clipped pixels") {
  cv::Mat image(60, 60, CV_8UC1, cv::Scalar(100));
  image(cv::Rect(30, 0, 30, 60)) = 255;
  Outline outline;
  outline.center = {29.5, 30.0};
  outline.axes *= 8.0;
  RimBand band;
  band.sample(image, outline, 40, -4.0, 4.0);
  CHECK((band.level.col(0).array() == RimBand::kClipped).all());
  CHECK((band.level.col(20).array() == 100.0f).all());
}

}  // namespace
}  // namespace planar
