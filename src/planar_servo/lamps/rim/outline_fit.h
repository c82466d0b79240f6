#pragma once

#include <Eigen/Core>

#include "planar_servo/lamps/rim/outline.h"

namespace planar {

/// An outline's terms, relative to the ellipse on which the normals stand, fitted to the offsets of
/// the edge along the normals.
struct OutlineFit {
  Outline::Terms terms{Outline::Terms::Zero()};
  Eigen::Matrix<double, Outline::kTerms, Outline::kTerms> covariance{
      Eigen::Matrix<double, Outline::kTerms, Outline::kTerms>::Zero()};
  bool has_waves{false};
};

/// Fits an outline by least squares weighted by `information`. The waves have a normal prior of
/// this variance; with 0 there are no waves.
OutlineFit fit_outline(const Normals& normals, const PerNormal& offset_px,
                       const PerNormal& information, double wave_variance_px2);

/// Fits an outline whose waves are as large as the offsets show: the variance of their prior is
/// estimated from the offsets [Morris 1983]. There are no waves when they are not significant.
OutlineFit fit_outline(const Normals& normals, const PerNormal& offset_px,
                       const PerNormal& information);

/// The fit to all normals but one arc, a little more than a quarter of the rim, and the normals
/// that it used.
struct ArcFit {
  OutlineFit fit;
  NormalFlags use;
};
/// Tries 32 arcs and leaves out the one without which the rest fits best.
ArcFit fit_without_arc(const Normals& normals, const PerNormal& offset_px,
                       const PerNormal& information, double wave_variance_px2);

/// Decides whether a normal agrees with a fit.
struct Agreement {
  double least_sigma_px;  ///< of an offset; the normals in use may show more
  double blur_px;         ///< of the edge; it spreads a fault to the neighbours
};

/// Returns the normals that agree with a fit. Their offset is within 4.5 standard deviations, and
/// no normal within the blur's reach disagrees. A run of normals that were not in use is taken back
/// from its ends only, as far as it agrees, because its inside may cross the outline by chance.
NormalFlags agreeing(const Normals& normals, const PerNormal& offset_px, const OutlineFit& fit,
                     const Agreement& agreement, const NormalFlags& readable,
                     const NormalFlags& use);

/// Returns the normals in use that are farther than the blur's reach from any that is not.
NormalFlags clear_of_others(const Normals& normals, const NormalFlags& use, double blur_px);

}  // namespace planar
