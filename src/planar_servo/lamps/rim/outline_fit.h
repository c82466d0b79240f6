#pragma once

#include <Eigen/Core>

#include "planar_servo/lamps/rim/outline.h"

namespace planar {

/// An outline's terms, relative to the ellipse that the normals stand on, from the places where the
/// edge crosses the normals.
struct OutlineFit {
  Outline::Terms terms{Outline::Terms::Zero()};
  Eigen::Matrix<double, Outline::kTerms, Outline::kTerms> covariance{
      Eigen::Matrix<double, Outline::kTerms, Outline::kTerms>::Zero()};
  bool has_waves{false};
};

/// Least squares. The waves have a normal prior of this variance; 0: there are none. Normals
/// without information have no say.
OutlineFit fit_outline(const Normals& normals, const PerNormal& offset_px,
                       const PerNormal& information, double wave_variance_px2);

/// With waves as large as the offsets show: their prior's variance is estimated from the offsets
/// [Morris 1983]; without waves when they are not significant.
OutlineFit fit_outline(const Normals& normals, const PerNormal& offset_px,
                       const PerNormal& information);

/// The fit to all but that arc, a little more than a quarter of the rim, which leaves the rest best
/// explained, and those normals.
struct ArcFit {
  OutlineFit fit;
  NormalFlags use;
};
ArcFit fit_without_arc(const Normals& normals, const PerNormal& offset_px,
                       const PerNormal& information, double wave_variance_px2);
/// Tries 32 arcs and leaves out the one without which the rest fits best.

/// What decides whether a normal agrees with a fit.
struct Agreement {
  double least_sigma_px;  ///< Decides whether a normal agrees with a fit.
  double blur_px;         ///< of the edge, which spreads what is wrong to the neighbours
};

/// The normals that agree with a fit: those within 4.5 standard deviations and out of reach, by the
/// blur, of one that does not agree. A run of normals that were not in use is taken back from its
/// ends only, as far as it agrees, so that a part of it that crosses the outline by chance stays
/// out.
NormalFlags agreeing(const Normals& normals, const PerNormal& offset_px, const OutlineFit& fit,
                     const Agreement& agreement, const NormalFlags& readable,
                     const NormalFlags& use);

}  // namespace planar
