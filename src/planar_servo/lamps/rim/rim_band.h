#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "planar_servo/lamps/rim/outline.h"

namespace planar {

/// The grey levels along the normals of an outline, at equal steps of the distance from it, waves
/// included. One column per normal; interpolated between the four nearest pixels.
struct RimBand {
  static constexpr int kPlaces = 16;
  static constexpr float kClipped = 255.0f;  ///< of a sample that is mostly of clipped pixels
  using Places = Eigen::Matrix<double, kPlaces, 1>;
  using Samples =
      Eigen::Matrix<float, kPlaces, Eigen::Dynamic, Eigen::ColMajor, kPlaces, Normals::kMost>;

  Normals normals;
  Places distance_px;  ///< from the outline, positive outside
  Samples level;
  Samples blur_px2;  ///< variance along the normal that the interpolation adds, less its mean

  double step_px() const { return distance_px[1] - distance_px[0]; }

  /// Samples from `inner_px` (negative) to `outer_px` (positive) across the outline at `count`
  /// normals. Beyond the image its outermost pixels go on.
  void sample(const cv::Mat& image, const Outline& outline, int count, double inner_px,
              double outer_px);
};

/// How many normals follow one another about every pixel of a rim.
int normals_round(double diameter_px);

}  // namespace planar
