#include "planar_servo/lamps/rim/light_centroid.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/lamps/rim/outline.h"
#include "planar_servo/lamps/rim/pixel_noise.h"

namespace planar {
namespace {

struct LightSums {
  int light{0}, first{0};  ///< light, and light times column
  int rim{0};              ///< pixels whose light is neither 0 nor full
};

LightSums sum_row(const std::uint8_t* row, int width, std::int16_t lowest, std::int16_t full) {
  constexpr std::int16_t kNone = 0;
  LightSums sums;
  for (int u = 0; u < width; ++u) {
    const auto above = static_cast<std::int16_t>(row[u] - lowest);
    const std::int16_t light = std::min(std::max(above, kNone), full);
    const auto is_rim = static_cast<std::int16_t>((light > kNone) & (light < full));
    sums.light += light;
    sums.first += static_cast<std::int16_t>(u) * light;
    sums.rim += is_rim;
  }
  return sums;
}

}  // namespace

std::optional<LightCentroid> light_centroid(const cv::Mat& image, const Blob& blob) {
  constexpr double kLowest = 0.2, kHighest = 0.8;
  constexpr int kMargin_px = 2;
  const auto level = [&](double share) {
    return static_cast<std::int16_t>(std::lround(blob.background + share * blob.contrast()));
  };
  const std::int16_t lowest = level(kLowest);
  const auto full = static_cast<std::int16_t>(level(kHighest) - lowest);
  if (full <= 0) return std::nullopt;
  const cv::Rect box =
      (blob.box_px + cv::Size(2 * kMargin_px, 2 * kMargin_px) - cv::Point(kMargin_px, kMargin_px)) &
      cv::Rect({0, 0}, image.size());
  double light = 0.0, rim = 0.0;
  Eigen::Vector2d first(0.0, 0.0);
  for (int v = 0; v < box.height; ++v) {
    const LightSums row =
        sum_row(image.ptr<std::uint8_t>(box.y + v) + box.x, box.width, lowest, full);
    light += row.light;
    first += Eigen::Vector2d(row.first, v * row.light);
    rim += row.rim;
  }
  if (light <= 0.0) return std::nullopt;
  const Eigen::Vector2d center = first / light;
  const PixelNoise noise = estimate_noise(image, outline_of(blob));
  const double variance = noise.variance(0.5 * (blob.level + blob.background));
  // An ellipse's rim has twice the second moments of its area.
  const Eigen::Vector2d lever = 2.0 * rim * blob.second_moments_px2.diagonal();
  LightCentroid centroid;
  centroid.center = center + Eigen::Vector2d(box.x, box.y);
  centroid.covariance = (variance / (light * light) * lever).asDiagonal();
  return centroid;
}

}  // namespace planar
