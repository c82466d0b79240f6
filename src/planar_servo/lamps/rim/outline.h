#pragma once

#include <Eigen/Core>

#include "planar_servo/lamps/blob.h"

namespace planar {

/// The outline of a lamp in an image, pixels: an ellipse with small waves along its normals, as a
/// real rim has.
struct Outline {
  static constexpr int kFirstWave = 3, kLastWave = 9;  // the ellipse takes the harmonics up to 2
  static constexpr int kShapeTerms = 5, kWaveTerms = 2 * (kLastWave - kFirstWave + 1);
  static constexpr int kTerms = kShapeTerms + kWaveTerms;
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  using Waves = Eigen::Matrix<double, kWaveTerms, 1>;

  Eigen::Vector2d center{0.0, 0.0};
  Eigen::Matrix2d axes{Eigen::Matrix2d::Identity()};  ///< symmetric; maps the unit circle to it
  Waves waves{Waves::Zero()};                         ///< cosine and sine of each harmonic

  /// Returns the diameter of the circle with the ellipse's area.
  double diameter() const;

  /// Adds the first five terms to the centre, axes(0, 0), axes(0, 1) and axes(1, 1), and sets the
  /// waves to the others.
  void change(const Terms& terms);
};

/// Returns the ellipse that has a blob's moments.
Outline outline_of(const Blob& blob);

/// One number for each normal of an outline.
constexpr int kMostNormals = 384;
using PerNormal = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostNormals, 1>;
using NormalFlags = Eigen::Array<bool, Eigen::Dynamic, 1, Eigen::ColMajor, kMostNormals, 1>;

/// The normals of an outline's ellipse, one column each. They stand at the images of equally spaced
/// points (cos a, sin a) of the unit circle, counted from a = 0.
struct Normals {
  static constexpr int kMost = kMostNormals, kHarmonics = 5;
  template <int Rows>
  using Columns = Eigen::Matrix<double, Rows, Eigen::Dynamic, Eigen::ColMajor, Rows, kMost>;

  Columns<2> foot;                ///< on the ellipse
  Columns<2> direction;           ///< outwards, of length 1
  Columns<Outline::kTerms> move;  ///< shift of the outline along the normal by a unit of each term
  Columns<kHarmonics> harmonics;  ///< 1, cos a, sin a, cos 2a, sin 2a
  PerNormal arc_px;               ///< arc of the ellipse from one normal to the next

  int count() const { return static_cast<int>(foot.cols()); }

  /// Computes `count` normals, at most kMost.
  void spread(const Outline& outline, int count);

  /// Returns how far a change of terms moves the outline along each normal.
  PerNormal moved(const Outline::Terms& terms) const;
  /// Returns how far the outline's waves lie outside its ellipse.
  PerNormal waves(const Outline& outline) const;

 private:
  void spread_harmonics(int count);
};

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

/// Fits an outline whose prior variance of the waves is estimated from the offsets [Morris 1983];
/// waves that are not significant are left out.
OutlineFit fit_outline(const Normals& normals, const PerNormal& offset_px,
                       const PerNormal& information);

/// The fit to all normals but one arc, a little more than a quarter of the rim, and the normals
/// that it used.
struct ArcFit {
  OutlineFit fit;
  NormalFlags use;
};
/// Tries 32 arcs and leaves out the one without which the others fit best.
ArcFit fit_without_arc(const Normals& normals, const PerNormal& offset_px,
                       const PerNormal& information, double wave_variance_px2);

/// What decides whether a normal agrees with a fit.
struct Agreement {
  double least_sigma_px;  ///< of an offset; the normals in use may show more
  double blur_px;         ///< of the edge; it spreads a fault to the neighbours
};

/// Returns the normals that agree with a fit. Their offset is within 4.5 standard deviations, and
/// no normal within the blur's reach disagrees. A run of normals that were not in use is restored
/// from its ends only, as far as it agrees, because its inside may cross the outline by chance.
NormalFlags agreeing(const Normals& normals, const PerNormal& offset_px, const OutlineFit& fit,
                     const Agreement& agreement, const NormalFlags& readable,
                     const NormalFlags& use);

/// Returns the normals in use that are farther than the blur's reach from any that is not.
NormalFlags clear_of_others(const Normals& normals, const NormalFlags& use, double blur_px);

}  // namespace planar
