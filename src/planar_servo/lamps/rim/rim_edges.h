#pragma once

#include <Eigen/Core>
#include <optional>

#include "planar_servo/lamps/rim/rim_band.h"

namespace planar {

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
