#include "planar_servo/lamps/rim/pixel_noise.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr double kRounding = 1.0 / 12.0;

/// Sums over the pixels of one side of the rim.
struct Side {
  int pixels{0}, level{0}, difference{0};

  void add_row(const std::uint8_t* row, int begin, int end) {
    for (int u = begin; u < end; ++u) {
      const int left = row[u - 1], here = row[u], right = row[u + 1];
      if (std::max({left, here, right}) == 255) continue;
      ++pixels;
      level += here;
      difference += std::abs(left - 2 * here + right);
    }
  }
  bool tells() const {
    constexpr int kLeastPixels = 50;
    return pixels >= kLeastPixels;
  }
  double mean_level() const { return static_cast<double>(level) / pixels; }
  /// Returns the variance of normal noise, whose second difference has 6 times the variance.
  double variance() const {
    const double mean = static_cast<double>(difference) / pixels;
    return std::max(kRounding, mean * mean * kPi / 2.0 / 6.0);
  }
};

/// Tells where the rows of an image cross an ellipse or a scaled copy of it.
class Rows {
 public:
  explicit Rows(const Outline& outline) : center_(outline.center) {
    const Eigen::Matrix2d moments = outline.axes * outline.axes;
    half_height_ = std::sqrt(moments(1, 1));
    lean_ = moments(0, 1) / moments(1, 1);
    half_width_ = std::sqrt(moments.determinant()) / half_height_;
  }

  double half_height() const { return half_height_; }
  double middle(double v) const { return center_.x() + lean_ * (v - center_.y()); }
  double half_width(double v, double scale) const {
    const double height = (v - center_.y()) / half_height_;
    const double square = scale * scale - height * height;
    return square > 0.0 ? half_width_ * std::sqrt(square) : 0.0;
  }

 private:
  Eigen::Vector2d center_;
  double half_height_, half_width_, lean_;
};

PixelNoise line_through(const Side& dark, const Side& bright) {
  constexpr double kLikelyAtZero = kRounding + 0.25, kLeastDifference = 10.0;
  if (!dark.tells()) return {kLikelyAtZero, 0.0};
  const double contrast = bright.tells() ? bright.mean_level() - dark.mean_level() : 0.0;
  PixelNoise noise;
  if (contrast > kLeastDifference) {
    noise.per_level = std::max(0.0, (bright.variance() - dark.variance()) / contrast);
    noise.at_zero = dark.variance() - noise.per_level * dark.mean_level();
  } else {
    noise.at_zero = std::min(kLikelyAtZero, dark.variance());
    noise.per_level = (dark.variance() - noise.at_zero) / std::max(1.0, dark.mean_level());
  }
  return noise;
}

}  // namespace

double PixelNoise::variance(double level) const {
  return std::max(kRounding, at_zero + per_level * level);
}

PixelNoise estimate_noise(const cv::Mat& image, const Outline& outline) {
  constexpr int kRowStep = 2;  // half of the rows suffices
  constexpr double kMargin_px = 4.0, kMarginInside = 0.3, kReach_px = 5.0;
  const double radius = 0.5 * outline.diameter();
  const double inner = 1.0 - std::max(kMargin_px / radius, kMarginInside);
  const double outer = 1.0 + kMargin_px / radius;
  const Rows rows(outline);
  Side dark, bright;
  const auto clamped = [&](double u) { return std::clamp(cvRound(u), 1, image.cols - 1); };
  const double reach = rows.half_height() * outer + kReach_px;
  const int first = std::max(0, static_cast<int>(outline.center.y() - reach));
  const int last = std::min(image.rows - 1, static_cast<int>(outline.center.y() + reach));
  for (int v = first; v <= last; v += kRowStep) {
    const double middle = rows.middle(v), in = rows.half_width(v, inner),
                 out = rows.half_width(v, outer);
    const auto* row = image.ptr<std::uint8_t>(v);
    if (in > 0.0) bright.add_row(row, clamped(middle - in), clamped(middle + in));
    dark.add_row(row, clamped(middle - out - kReach_px), clamped(middle - out));
    dark.add_row(row, clamped(middle + out), clamped(middle + out + kReach_px));
  }
  return line_through(dark, bright);
}

}  // namespace planar
