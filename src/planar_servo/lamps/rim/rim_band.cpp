#include "planar_servo/lamps/rim/rim_band.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "planar_servo/base/core/units.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace planar {
namespace {

constexpr float kMeanBlur_px2 = 1.0f / 6.0f, kMostly = 0.5f;
constexpr int kFull = 255;

bool lies_inside(const cv::Size& image, const Outline& outline, double reach_px) {
  constexpr double kMargin_px = 4.0;
  const Eigen::Vector2d half = (outline.axes * outline.axes).diagonal().cwiseSqrt();
  const Eigen::Vector2d least = outline.center - half, most = outline.center + half;
  const double margin = reach_px + outline.waves.lpNorm<1>() + kMargin_px;
  return least.minCoeff() > margin && most.x() < image.width - margin &&
         most.y() < image.height - margin;
}

}  // namespace

// Interpolation at the fractions a, b of a pixel blurs an edge across the direction n by the
// variance n_u^2 a (1 - a) + n_v^2 b (1 - b).
void sample_line(const cv::Mat& image, const BandLine& line, float* level, float* blur_px2) {
  for (int j = 0; j < RimBand::kPlaces; ++j) {
    const auto place = static_cast<float>(j);
    const float u =
        std::clamp(line.u + place * line.du, 0.0f, static_cast<float>(image.cols) - 1.001f);
    const float v =
        std::clamp(line.v + place * line.dv, 0.0f, static_cast<float>(image.rows) - 1.001f);
    const int left = static_cast<int>(u), top = static_cast<int>(v);
    const float a = u - static_cast<float>(left), b = v - static_cast<float>(top);
    const std::uint8_t* high = image.ptr<std::uint8_t>(top) + left;
    const std::uint8_t* low = image.ptr<std::uint8_t>(top + 1) + left;
    const int pixels[4] = {high[0], high[1], low[0], low[1]};
    const float weights[4] = {(1.0f - a) * (1.0f - b), a * (1.0f - b), (1.0f - a) * b, a * b};
    float sum = 0.0f, full = 0.0f;
    for (int i = 0; i < 4; ++i) {
      sum += weights[i] * static_cast<float>(pixels[i]);
      full += pixels[i] == kFull ? weights[i] : 0.0f;
    }
    level[j] = full > kMostly ? static_cast<float>(kFull) : sum;
    blur_px2[j] = line.nu2 * (a - a * a) + line.nv2 * (b - b * b) - kMeanBlur_px2;
  }
}

#if defined(__x86_64__)

bool has_fast_lines() {
  return __builtin_cpu_supports("avx2") != 0;
}

__attribute__((target("avx2"))) void sample_line_fast(const cv::Mat& image, const BandLine& line,
                                                      float* level, float* blur_px2) {
  const auto* pixels = reinterpret_cast<const int*>(image.data);
  const auto* pixels_below = reinterpret_cast<const int*>(image.data + image.step[0]);
  const __m256i row = _mm256_set1_epi32(static_cast<int>(image.step[0]));
  const __m256i byte = _mm256_set1_epi32(255);
  const __m256 one = _mm256_set1_ps(1.0f);
  __m256 place = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
  for (int j = 0; j < RimBand::kPlaces;
       j += 8, place = _mm256_add_ps(place, _mm256_set1_ps(8.0f))) {
    const __m256 u =
        _mm256_add_ps(_mm256_set1_ps(line.u), _mm256_mul_ps(place, _mm256_set1_ps(line.du)));
    const __m256 v =
        _mm256_add_ps(_mm256_set1_ps(line.v), _mm256_mul_ps(place, _mm256_set1_ps(line.dv)));
    const __m256i left = _mm256_cvttps_epi32(u), top = _mm256_cvttps_epi32(v);
    const __m256 a = _mm256_sub_ps(u, _mm256_cvtepi32_ps(left));
    const __m256 b = _mm256_sub_ps(v, _mm256_cvtepi32_ps(top));
    const __m256i at = _mm256_add_epi32(_mm256_mullo_epi32(top, row), left);
    const __m256i high = _mm256_i32gather_epi32(pixels, at, 1);
    const __m256i low = _mm256_i32gather_epi32(pixels_below, at, 1);
    const __m256 a1 = _mm256_sub_ps(one, a), b1 = _mm256_sub_ps(one, b);
    const __m256i corner[4] = {
        _mm256_and_si256(high, byte), _mm256_and_si256(_mm256_srli_epi32(high, 8), byte),
        _mm256_and_si256(low, byte), _mm256_and_si256(_mm256_srli_epi32(low, 8), byte)};
    const __m256 weight[4] = {_mm256_mul_ps(a1, b1), _mm256_mul_ps(a, b1), _mm256_mul_ps(a1, b),
                              _mm256_mul_ps(a, b)};
    __m256 sum = _mm256_setzero_ps(), full = _mm256_setzero_ps();
    for (int i = 0; i < 4; ++i) {
      sum = _mm256_add_ps(sum, _mm256_mul_ps(weight[i], _mm256_cvtepi32_ps(corner[i])));
      const __m256 is_full = _mm256_castsi256_ps(_mm256_cmpeq_epi32(corner[i], byte));
      full = _mm256_add_ps(full, _mm256_and_ps(is_full, weight[i]));
    }
    const __m256 mostly = _mm256_cmp_ps(full, _mm256_set1_ps(kMostly), _CMP_GT_OQ);
    _mm256_storeu_ps(level + j, _mm256_blendv_ps(sum, _mm256_cvtepi32_ps(byte), mostly));
    const __m256 spread_u = _mm256_sub_ps(a, _mm256_mul_ps(a, a));
    const __m256 spread_v = _mm256_sub_ps(b, _mm256_mul_ps(b, b));
    const __m256 blur = _mm256_add_ps(_mm256_mul_ps(_mm256_set1_ps(line.nu2), spread_u),
                                      _mm256_mul_ps(_mm256_set1_ps(line.nv2), spread_v));
    _mm256_storeu_ps(blur_px2 + j, _mm256_sub_ps(blur, _mm256_set1_ps(kMeanBlur_px2)));
  }
}

#else

bool has_fast_lines() {
  return false;
}

void sample_line_fast(const cv::Mat& image, const BandLine& line, float* level, float* blur_px2) {
  sample_line(image, line, level, blur_px2);
}

#endif

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
