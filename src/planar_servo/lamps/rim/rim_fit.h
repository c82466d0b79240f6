#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include <optional>

#include "planar_servo/lamps/blob.h"
#include "planar_servo/lamps/rim/rim_band.h"

namespace planar {

/// The outline of a lamp to a small part of a pixel.
struct RimFit {
  Eigen::Vector2d center{0.0, 0.0};
  Eigen::Matrix2d center_covariance{Eigen::Matrix2d::Zero()};
  double diameter{0.0};     ///< of the circle with the ellipse's area
  double blur_px{0.0};      ///< standard deviation; 0 where only half-level edges were measured
  double largest_gap{0.0};  ///< widest angle round the rim that was left out, radians
};

/// Fits an ellipse with a wavy rim to the grey levels along its normals, up to `reach_px` outside
/// it (at most 4.5 px). Departures from an even disc are fitted only as far as the image shows
/// them: levels and slopes that change round the rim (measure_edges), waves (fit_outline),
/// stretches that are not part of the outline (agreeing), clipped pixels. The covariance follows
/// from noise estimated in the image. A rim whose levels do not fit (interlaced or compressed
/// images, lamps of few pixels) is measured by its half-level edges, with the covariance of their
/// scatter. Empty when there is no rim to fit.
std::optional<RimFit> fit_rim(const cv::Mat& image, const Blob& blob, double reach_px);

/// The grey levels beside a rim, as sums of harmonics round the rim.
struct RimLevels {
  static constexpr int kKinds = 4;  // dark, bright, dark slope, bright slope
  static constexpr int kTerms = kKinds * Normals::kHarmonics;

  Eigen::Matrix<double, kKinds, Normals::kHarmonics> harmonics;
  /// Covariance of the harmonics, kind by kind; zero where a harmonic was not needed.
  Eigen::Matrix<double, kTerms, kTerms> covariance;
};

/// The places where the edge crosses the normals of a band.
struct RimEdges {
  PerNormal offset_px;    ///< from the ellipse of the band's outline, positive outside
  PerNormal information;  ///< 1 / variance for given levels, in 1/px^2; 0 where it is not used
  NormalFlags readable;   ///< false where pixels are clipped that are not on the other normals
  double blur_px;         ///< standard deviation, the interpolation's included
  RimLevels levels;
  /// Shift of each normal's offset by a unit of each kind of level.
  Normals::Columns<RimLevels::kKinds> moved_by_level;
};

/// Measures the edges in a band by generalised least squares, linear in small distances from the
/// band's outline. It fits the profile of all normals in `use` together, then the levels and slopes
/// of both sides, with two harmonics round the rim where they are significant, and last each
/// normal's edge between these levels. Empty when clipped pixels leave too little of the profile.
std::optional<RimEdges> measure_edges(const RimBand& band, const Outline& outline,
                                      const PixelNoise& noise, const NormalFlags& use);

}  // namespace planar
