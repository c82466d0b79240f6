#include "planar_servo/virtual_cell/image/sensor_noise.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr std::size_t kQuantiles = 1U << 16;
constexpr int kBankSize = 1 << 20;

/// Returns the quantiles of the normal distribution at the midpoints of equal shares, so that an
/// entry picked by 16 random bits is a normal number. Newton's method finds each from its
/// neighbour, outwards from the median.
std::vector<float> normal_quantiles() {
  std::vector<float> quantiles(kQuantiles);
  double x = 0.0;
  for (std::size_t i = kQuantiles / 2; i < kQuantiles; ++i) {
    const double upper_tail = 1.0 - (static_cast<double>(i) + 0.5) / kQuantiles;
    for (int iteration = 0; iteration < 6; ++iteration) {
      const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * kPi);
      x += (0.5 * std::erfc(x / std::sqrt(2.0)) - upper_tail) / density;
    }
    quantiles[i] = static_cast<float>(x);
    quantiles[kQuantiles - 1 - i] = static_cast<float>(-x);
  }
  return quantiles;
}

}  // namespace

SensorNoise::SensorNoise(const NoiseTruth& truth, std::uint64_t seed)
    : truth_(truth), normals_(normal_quantiles()), bank_(kBankSize) {
  Random random(seed, RandomStream::kNoiseBank);
  expose(cv::Mat1f(1, kBankSize, 0.0F), cv::Mat(1, kBankSize, CV_8UC1, bank_.data()), random);
}

void SensorNoise::fill_dark(cv::Mat& image, Random& random) const {
  const std::size_t width = static_cast<std::size_t>(image.cols);
  for (int row = 0; row < image.rows; ++row) {
    const std::size_t offset = random.bits() % (bank_.size() - width + 1);
    std::memcpy(image.ptr(row), bank_.data() + offset, width);
  }
}

void SensorNoise::expose(const cv::Mat1f& levels, cv::Mat image, Random& random) const {
  const float background = static_cast<float>(truth_.background_level);
  const float shot = static_cast<float>(1.0 / truth_.gain_e_per_level);
  const float read = static_cast<float>(truth_.read_noise_levels * truth_.read_noise_levels);
  for (int row = 0; row < levels.rows; ++row) {
    const float* level = levels.ptr<float>(row);
    std::uint8_t* pixel = image.ptr(row);
    std::uint64_t bits = 0;
    for (int column = 0; column < levels.cols; ++column) {
      bits = column % 4 == 0 ? random.bits() : bits >> 16;
      const float light = level[column] + background;
      const float noise = std::sqrt(light * shot + read) * normals_[bits & 0xffff];
      const float rounded_up = light + noise + 0.5F;  // the cast below truncates
      pixel[column] = static_cast<std::uint8_t>(std::clamp(rounded_up, 0.0F, 255.0F));
    }
  }
}

}  // namespace planar
