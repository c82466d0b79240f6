#include "planar_servo/virtual_cell/virtual_cell.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace planar {
namespace {

constexpr int kSide = 500;
constexpr double kPixels = kSide * kSide;
constexpr double kRounding = 1.0 / 12.0;  // variance of rounding to whole levels
constexpr double kSigmas = 5.0;

struct Moments {
  double mean, variance;
};

Moments moments(const cv::Mat& image) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(image, mean, deviation);
  return {mean[0], deviation[0] * deviation[0]};
}

Moments exposed(double level) {
  const SensorNoise noise(NoiseTruth{}, 1);
  Random random(1, RandomStream::kFrame, 7);
  cv::Mat image(kSide, kSide, CV_8UC1);
  noise.expose(cv::Mat1f(kSide, kSide, static_cast<float>(level)), image, random);
  return moments(image);
}

}  // namespace

TEST_CASE("A lit pixel has the mean of its level and the variance of shot, read and rounding") {
  for (const double level : {0.0, 40.0, 160.0}) {
    const Moments m = exposed(level);
    const double variance = (level + 12.0) / 18.6 + 0.25 + kRounding;
    CHECK(m.mean == Approx(level + 12.0).margin(kSigmas * std::sqrt(variance / kPixels)));
    CHECK(m.variance == Approx(variance).epsilon(kSigmas * std::sqrt(2.0 / kPixels)));
  }
}

TEST_CASE("Levels beyond the brightest value are clipped") {
  CHECK(exposed(400.0).mean == 255.0);
}

TEST_CASE("The dark bank has the statistics of exposed dark pixels") {
  const SensorNoise noise(NoiseTruth{}, 2);
  Random random(2, RandomStream::kFrame);
  cv::Mat image(kSide, kSide, CV_8UC1);
  noise.fill_dark(image, random);
  const Moments m = moments(image);
  const double variance = 12.0 / 18.6 + 0.25 + kRounding;
  CHECK(m.mean == Approx(12.0).margin(kSigmas * std::sqrt(variance / kPixels)));
  CHECK(m.variance == Approx(variance).epsilon(kSigmas * std::sqrt(2.0 / kPixels)));
}

TEST_CASE("Random draws uniform and normal numbers of the right moments") {
  Random random(11, RandomStream::kDraw);
  constexpr int kDraws = 200000;
  double normal = 0.0, normal2 = 0.0, normal4 = 0.0, uniform = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.normal();
    normal += x / kDraws;
    normal2 += x * x / kDraws;
    normal4 += x * x * x * x / kDraws;
    uniform += random.uniform(2.0, 4.0) / kDraws;
  }
  const double sigma = std::sqrt(1.0 / kDraws);
  CHECK(normal == Approx(0.0).margin(kSigmas * sigma));
  CHECK(normal2 == Approx(1.0).margin(kSigmas * sigma * std::sqrt(2.0)));
  CHECK(normal4 == Approx(3.0).margin(kSigmas * sigma * std::sqrt(96.0)));
  CHECK(uniform == Approx(3.0).margin(kSigmas * sigma / std::sqrt(3.0)));
}

TEST_CASE("Streams, indices and seeds of Random differ and repeat") {
  const auto first = [](std::uint64_t seed, RandomStream stream, std::uint64_t index) {
    return Random(seed, stream, index).bits();
  };
  const std::uint64_t reference = first(1, RandomStream::kFrame, 1);
  CHECK(first(1, RandomStream::kFrame, 1) == reference);
  CHECK(first(2, RandomStream::kFrame, 1) != reference);
  CHECK(first(1, RandomStream::kBoard, 1) != reference);
  CHECK(first(1, RandomStream::kFrame, 2) != reference);
}

}  // namespace planar
