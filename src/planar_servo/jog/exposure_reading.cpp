#include "planar_servo/jog/exposure_reading.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>

namespace planar {
namespace {

constexpr int kWhite = 255;
constexpr int kLeastPeak = 128;  // below this, half of the grey levels are unused
/// The share of lit pixels that may be saturated. Lamps are measured by their edges, which clipping
/// at the top leaves alone; a larger share says that the edges are clipped soon.
constexpr double kMostSaturated = 0.02;
constexpr std::size_t kHotPixels = 20;
constexpr int kBarWidth = 32;

using Histogram = std::array<std::size_t, 256>;

Histogram histogram_of(const cv::Mat& image) {
  Histogram counts{};
  for (int row = 0; row < image.rows; ++row) {
    const auto* pixel = image.ptr<unsigned char>(row);
    for (int column = 0; column < image.cols; ++column) ++counts[pixel[column]];
  }
  return counts;
}

/// Returns the highest level that more than `n` pixels reach.
int level_reached(const Histogram& counts, std::size_t n) {
  std::size_t above = 0;
  for (int level = kWhite; level > 0; --level) {
    above += counts[static_cast<std::size_t>(level)];
    if (above > n) return level;
  }
  return 0;
}

}  // namespace

bool ExposureReading::too_dark() const {
  return peak_level < kLeastPeak;
}

bool ExposureReading::too_bright() const {
  return saturated_share > kMostSaturated;
}

std::string ExposureReading::text() const {
  const auto filled = static_cast<std::size_t>(kBarWidth * peak_level / kWhite);
  return fmt::format("[{}{}] peak {} of {}, {:.1f} % of the lit pixels saturated: {}",
                     std::string(filled, '='), std::string(kBarWidth - filled, ' '), peak_level,
                     kWhite, 100.0 * saturated_share,
                     too_bright() ? "too bright, expose less"
                     : too_dark() ? "too dark, expose more"
                                  : "good");
}

ExposureReading read_exposure(const cv::Mat& image) {
  const Histogram counts = histogram_of(image);
  ExposureReading reading;
  reading.peak_level = level_reached(counts, kHotPixels);
  const int median = level_reached(counts, image.total() / 2);
  std::size_t lit = 0;
  for (int level = (median + reading.peak_level) / 2 + 1; level <= kWhite; ++level)
    lit += counts[static_cast<std::size_t>(level)];
  if (lit > 0)
    reading.saturated_share = static_cast<double>(counts[kWhite]) / static_cast<double>(lit);
  return reading;
}

}  // namespace planar
