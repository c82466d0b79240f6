#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "planar_servo/lamps/rim/outline.h"

namespace planar {

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

}  // namespace planar
