#pragma once

#include <Eigen/Core>
#include <optional>

#include "planar_servo/lamps/rim/edge_profile.h"
#include "planar_servo/lamps/rim/pixel_noise.h"
#include "planar_servo/lamps/rim/rim_band.h"

namespace planar {

/// The levels beside the rim that an EdgeProfile has, as sums of harmonics round it.
struct RimLevels {
  static constexpr int kKinds = 4;  // dark, bright, dark slope, bright slope
  static constexpr int kTerms = kKinds * Normals::kHarmonics;

  Eigen::Matrix<double, kKinds, Normals::kHarmonics> harmonics;
  /// Of the harmonics, kind by kind; zero where a harmonic was not needed.
  Eigen::Matrix<double, kTerms, kTerms> covariance;
};

/// Where the edge crosses each normal of a band.
struct RimEdges {
  PerNormal offset_px;    ///< from the ellipse of the band's outline, positive outside
  PerNormal information;  ///< 1 / variance for given levels, in 1/px^2; 0 where it is not used
  NormalFlags readable;   ///< false where pixels are clipped that are not on the other normals
  double blur_px;         ///< standard deviation, the interpolation's included
  RimLevels levels;
  /// What a unit of each kind of level, there, moves an offset by.
  Normals::Columns<RimLevels::kKinds> moved_by_level;
};

/// Measures the edges in a band by generalised least squares that are linear in small distances
/// from the band's outline. First the profile of all the normals in `use` together; then the levels
/// of both sides and their slopes across the rim, whose first two harmonics round it are taken only
/// where they are significant; then each normal's edge between these levels. Empty when the clipped
/// pixels leave too little of the profile.
std::optional<RimEdges> measure_edges(const RimBand& band, const Outline& outline,
                                      const PixelNoise& noise, const NormalFlags& use);

}  // namespace planar
