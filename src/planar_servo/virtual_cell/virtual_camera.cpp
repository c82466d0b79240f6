#include "planar_servo/virtual_cell/virtual_camera.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "planar_servo/base/core/units.h"

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

/// Adds `factor` times a light to the levels of a part of the sensor.
void add(const Light& light, double factor, const cv::Rect& part_px, cv::Mat1f& levels) {
  const cv::Rect lit_px = light.window_px & part_px;
  if (lit_px.empty()) return;
  cv::Mat1f sum = levels(lit_px - part_px.tl());
  cv::scaleAdd(light.levels(lit_px - light.window_px.tl()), factor, sum, sum);
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

VirtualCamera::VirtualCamera(const Truth& truth, const VirtualHardware& hardware,
                             const VirtualLens& lens, VirtualArm& arm, const VirtualBoard& board,
                             VirtualClock& clock)
    : sensor_px_(hardware.sensor_px),
      frame_rate_hz_(hardware.frame_rate_hz),
      seed_(truth.seed),
      lens_(lens),
      arm_(arm),
      board_(board),
      clock_(clock),
      lamps_(truth),
      works_(truth, lens, hardware.sensor_px),
      noise_(truth.noise, truth.seed),
      region_px_(cv::Point(), hardware.sensor_px) {}

void VirtualCamera::set_region(const cv::Rect& region_px) {
  require_region(region_px, sensor_px_);
  region_px_ = region_px;
}

void VirtualCamera::set_exposure(const CameraExposure& exposure) {
  require_exposure(exposure);
  exposure_ = exposure;
}

FrameResult VirtualCamera::next_frame() {
  const auto periods = static_cast<std::uint64_t>(std::ceil(clock_.now_s() * frame_rate_hz_));
  const std::uint64_t exposure = std::max(periods, next_exposure_);
  next_exposure_ = exposure + 1;
  const double t_s = static_cast<double>(exposure) / frame_rate_hz_;
  clock_.advance_to(std::max(t_s, clock_.now_s()));

  ++taken_;
  const double brightness =
      exposure_.time_s / kUsualTime_s * std::pow(10.0, exposure_.gain_db / 20.0);
  const cv::Mat image =
      arm_.moves() ? expose_moving(brightness, exposure) : expose(region_px_, brightness, exposure);
  return {FrameStatus::kOk, {image, region_px_, t_s, exposure}};
}

cv::Mat VirtualCamera::expose_moving(double brightness, std::uint64_t exposure) {
  const double begin_s = clock_.now_s();
  cv::Mat1f levels(region_px_.size(), 0.0F);
  for (int i = 0; i < kMomentsOfExposure; ++i) {
    clock_.advance_to(begin_s + (i + 0.5) / kMomentsOfExposure * exposure_.time_s);
    for (const Light& seen : lights(clock_.now_s()))
      add(seen, brightness / kMomentsOfExposure, region_px_, levels);
  }
  clock_.advance_to(begin_s + exposure_.time_s);
  cv::Mat image(region_px_.size(), CV_8UC1);
  Random random(seed_, RandomStream::kFrame, exposure);
  noise_.expose(levels, image, random);
  return image;
}

cv::Mat VirtualCamera::expose(const cv::Rect& region_px, double brightness,
                              std::uint64_t exposure) {
  require_region(region_px, sensor_px_);
  cv::Mat image(region_px.size(), CV_8UC1);
  Random random(seed_, RandomStream::kFrame, exposure);
  noise_.fill_dark(image, random);
  const std::vector<Light> all = lights(clock_.now_s());
  for (auto seen = all.begin(); seen != all.end(); ++seen) {
    const cv::Rect lit_px = seen->window_px & region_px;
    if (lit_px.empty()) continue;
    cv::Mat1f levels;
    seen->levels(lit_px - seen->window_px.tl()).convertTo(levels, CV_32F, brightness);
    // What was exposed before is exposed again with this light on it.
    for (auto below = all.begin(); below != seen; ++below) add(*below, brightness, lit_px, levels);
    noise_.expose(levels, image(lit_px - region_px.tl()), random);
  }
  return image;
}

std::vector<Light> VirtualCamera::lights(double t_s) {
  if (!board_.X_BG()) {
    const Pose X_BT = arm_.X_BT();
    std::vector<Light> all;
    if (!works_.empty()) all = works_.render(t_s, lamps_.housings_px(X_BT, lens_, t_s));
    for (Light& light : lamps_.render_all(X_BT, lens_, t_s)) all.push_back(std::move(light));
    return all;
  }
  const std::optional<Light> board = board_.render(t_s);
  return board ? std::vector<Light>{*board} : std::vector<Light>();
}

}  // namespace planar
