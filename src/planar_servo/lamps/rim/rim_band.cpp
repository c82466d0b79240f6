#include "planar_servo/lamps/rim/rim_band.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "planar_servo/core/units.h"
#include "planar_servo/lamps/rim/band_line.h"

namespace planar {
namespace {

bool lies_inside(const cv::Size& image, const Outline& outline, double reach_px) {
  constexpr double kMargin_px = 4.0;
  const Eigen::Vector2d half = (outline.axes * outline.axes).diagonal().cwiseSqrt();
  const Eigen::Vector2d least = outline.center - half, most = outline.center + half;
  const double margin = reach_px + outline.waves.lpNorm<1>() + kMargin_px;
  return least.minCoeff() > margin && most.x() < image.width - margin &&
         most.y() < image.height - margin;
}

}  // namespace

int normals_round(double diameter_px) {
  constexpr int kLeast = 32, kMultiple = 4;
  const int pixels = static_cast<int>(std::ceil(kPi * diameter_px / kMultiple)) * kMultiple;
  return std::clamp(pixels, kLeast, Normals::kMost);
}

void RimBand::sample(const cv::Mat& image, const Outline& outline, int count, double inner_px,
                     double outer_px) {
  distance_px = Places::LinSpaced(inner_px, outer_px);
  normals.spread(outline, count);
  level.resize(kPlaces, count);
  blur_px2.resize(kPlaces, count);
  const PerNormal wave = normals.waves(outline);
  const bool is_fast =
      has_fast_lines() && lies_inside(image.size(), outline, std::max(-inner_px, outer_px));
  const auto sample = is_fast ? sample_line_fast : sample_line;
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector2d direction = normals.direction.col(k);
    const Eigen::Vector2f begin =
        (normals.foot.col(k) + (wave[k] + inner_px) * direction).cast<float>();
    const Eigen::Vector2f step = (step_px() * direction).cast<float>();
    const Eigen::Vector2f squares = direction.cwiseAbs2().cast<float>();
    sample(image, {begin.x(), begin.y(), step.x(), step.y(), squares.x(), squares.y()},
           &level(0, k), &blur_px2(0, k));
  }
}

}  // namespace planar
