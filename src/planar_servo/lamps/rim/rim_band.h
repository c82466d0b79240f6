#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "planar_servo/lamps/rim/outline.h"

namespace planar {

/// Equally spaced points on a straight line in an image: they begin at (u, v) and continue in steps
/// of (du, dv).
struct BandLine {
  float u, v, du, dv;
  float nu2, nv2;  ///< squared components of the line's direction
};

/// Interpolates an 8-bit image at the 16 points of a line, each between the four nearest pixels,
/// and writes levels and blurs (see RimBand). A sample whose pixels are mostly at 255 becomes 255.
/// Points outside the image take its outermost pixels.
void sample_line(const cv::Mat& image, const BandLine& line, float* level, float* blur_px2);

/// Does what sample_line() does, to the last bit, eight points at a time. Call it only where
/// has_fast_lines() and with all points at least 4 px inside the image.
void sample_line_fast(const cv::Mat& image, const BandLine& line, float* level, float* blur_px2);
bool has_fast_lines();

/// The grey levels along the normals of an outline at equal steps of the distance from it, waves
/// included. There is one column per normal, interpolated between the four nearest pixels.
struct RimBand {
  static constexpr int kPlaces = 16;
  static constexpr float kClipped = 255.0f;  ///< level of a sample that is mostly of clipped pixels
  using Places = Eigen::Matrix<double, kPlaces, 1>;
  using Samples =
      Eigen::Matrix<float, kPlaces, Eigen::Dynamic, Eigen::ColMajor, kPlaces, Normals::kMost>;

  Normals normals;
  Places distance_px;  ///< from the outline, positive outside
  Samples level;
  Samples blur_px2;  ///< variance along the normal that interpolation adds, less its mean

  double step_px() const { return distance_px[1] - distance_px[0]; }

  /// Samples the image from `inner_px` (negative) to `outer_px` (positive) across the outline at
  /// `count` normals. Points outside the image take its outermost pixels.
  void sample(const cv::Mat& image, const Outline& outline, int count, double inner_px,
              double outer_px);
};

/// Returns the number of normals for a rim, about one per pixel of it.
int normals_round(double diameter_px);

/// The variance of a pixel's grey level as a line in the level: at_zero + per_level * level.
struct PixelNoise {
  double at_zero{0.0};
  double per_level{0.0};

  double variance(double level) const;
};

/// Estimates the noise from second differences along the rows, well inside and well outside the
/// lamp. Where one side gives too few pixels (the lamp is clipped or small), the variance at level
/// zero is that of rounding and of half a level of read noise.
PixelNoise estimate_noise(const cv::Mat& image, const Outline& outline);

}  // namespace planar
