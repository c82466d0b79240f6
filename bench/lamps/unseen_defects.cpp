#include "lamps/unseen_defects.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "planar_servo/base/core/units.h"

namespace planar::bench {
namespace {

constexpr double kRadius_px = 20.0, kAmplitude = 180.0;
constexpr int kSamples = 8;  // samples per pixel and axis

using Point = Eigen::Vector2d;
using Light = std::function<double(const Point&)>;

Point direction(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

double uniform(std::mt19937& random, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(random);
}

Point draw_center(std::mt19937& random) {
  const double u = uniform(random, -0.5, 0.5);
  return Point::Constant(0.5 * kWindowSide_px) + Point(u, uniform(random, -0.5, 0.5));
}

/// Takes the mean of the light over every pixel, through a lens that blurs by 0.7 to 1 px.
LampSample expose_through_lens(const Point& center, const Light& light, std::mt19937& random) {
  cv::Mat fine(kWindowSide_px * kSamples, kWindowSide_px * kSamples, CV_32F);
  for (int row = 0; row < fine.rows; ++row) {
    for (int column = 0; column < fine.cols; ++column) {
      const Point p((column + 0.5) / kSamples - 0.5, (row + 0.5) / kSamples - 0.5);
      fine.at<float>(row, column) = static_cast<float>(light(p));
    }
  }
  LampSample sample{{}, center, std::nullopt};
  cv::resize(fine, sample.scene, {kWindowSide_px, kWindowSide_px}, 0.0, 0.0, cv::INTER_AREA);
  const double blur_px = uniform(random, 0.7, 1.0);
  cv::GaussianBlur(sample.scene, sample.scene, cv::Size(), blur_px, blur_px, cv::BORDER_REPLICATE);
  return sample;
}

double disc(const Point& p, const Point& center, double radius_px) {
  return (p - center).norm() < radius_px ? 1.0 : 0.0;
}

LampSample draw_scratched(std::mt19937& random) {
  constexpr double kThrough = 0.35;  // share of the light that passes a scratch or a speck
  struct Speck {
    Point center;
    double radius_px;
  };
  const Point center = draw_center(random);
  const Point across = direction(uniform(random, 0.0, 2.0 * kPi));
  const double offset_px = uniform(random, -0.7, 0.7) * kRadius_px;
  const double half_width_px = uniform(random, 0.5, 1.25);
  std::vector<Speck> dust(static_cast<std::size_t>(uniform(random, 3.0, 8.0)));
  for (Speck& speck : dust) {
    speck.center = center + uniform(random, 0.0, 1.0) * kRadius_px *
                                direction(uniform(random, 0.0, 2.0 * kPi));
    speck.radius_px = uniform(random, 0.7, 2.5);
  }
  const auto light = [&](const Point& p) {
    double through =
        std::abs((p - center).dot(across) - offset_px) < half_width_px ? kThrough : 1.0;
    for (const Speck& speck : dust) {
      if ((p - speck.center).norm() < speck.radius_px) through = kThrough;
    }
    return kBackground + kAmplitude * through * disc(p, center, kRadius_px);
  };
  return expose_through_lens(center, light, random);
}

LampSample draw_reflection(std::mt19937& random) {
  const Point center = draw_center(random);
  const double radius_px = uniform(random, 0.4, 0.8) * kRadius_px;
  const double share = uniform(random, 0.2, 0.5);
  const Point other =
      center + uniform(random, 0.9, 1.2) * kRadius_px * direction(uniform(random, 0.0, 2.0 * kPi));
  const double amplitude = 160.0;  // lamp and reflection together stay under 255
  const auto light = [&](const Point& p) {
    return kBackground +
           amplitude * (disc(p, center, kRadius_px) + share * disc(p, other, radius_px));
  };
  return expose_through_lens(center, light, random);
}

/// Draws a moving disc. A point is lit for the share of the exposure in which the disc covers it: a
/// chord in the direction of the move.
LampSample draw_smeared(std::mt19937& random) {
  const Point center = draw_center(random);
  const Point along = direction(uniform(random, 0.0, 2.0 * kPi)), across(-along.y(), along.x());
  const double half_px = 0.5 * uniform(random, 2.0, 6.0);
  const auto light = [&](const Point& p) {
    const double x = (p - center).dot(along), y = (p - center).dot(across);
    if (std::abs(y) >= kRadius_px) return kBackground;
    const double chord = std::sqrt(kRadius_px * kRadius_px - y * y);
    const double covered =
        std::max(0.0, std::min(half_px, x + chord) - std::max(-half_px, x - chord));
    return kBackground + kAmplitude * covered / (2.0 * half_px);
  };
  return expose_through_lens(center, light, random);
}

}  // namespace

std::vector<LampFamily> unseen_families() {
  return {
      {"scratched", draw_scratched}, {"reflection", draw_reflection}, {"smeared", draw_smeared}};
}

}  // namespace planar::bench
