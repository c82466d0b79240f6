#pragma once

#include <Eigen/Core>

#include "planar_servo/lamps/detect/blob.h"

namespace planar {

/// The outline of a lamp in an image: an ellipse, and the waves along its normals that a real rim
/// has. Pixels.
struct Outline {
  static constexpr int kFirstWave = 3, kLastWave = 9;  // an ellipse takes the harmonics up to 2
  static constexpr int kShapeTerms = 5, kWaveTerms = 2 * (kLastWave - kFirstWave + 1);
  static constexpr int kTerms = kShapeTerms + kWaveTerms;
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  using Waves = Eigen::Matrix<double, kWaveTerms, 1>;

  Eigen::Vector2d center{0.0, 0.0};
  Eigen::Matrix2d axes{Eigen::Matrix2d::Identity()};  ///< symmetric; maps the unit circle to it
  Waves waves{Waves::Zero()};                         ///< cosine and sine of each harmonic

  /// Of the circle with the ellipse's area.
  double diameter() const;

  /// Moves the ellipse by the changes of its centre, axes(0, 0), axes(0, 1) and axes(1, 1), which
  /// are the first of these terms; the others are the new waves.
  void change(const Terms& terms);
};

/// The ellipse with a blob's moments.
Outline outline_of(const Blob& blob);

/// A number for each normal of an outline.
constexpr int kMostNormals = 384;
using PerNormal = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostNormals, 1>;
using NormalFlags = Eigen::Array<bool, Eigen::Dynamic, 1, Eigen::ColMajor, kMostNormals, 1>;

/// The normals of an outline's ellipse at the images of equally spaced points of the unit circle,
/// (cos a, sin a), counted from a = 0. One column each.
struct Normals {
  static constexpr int kMost = kMostNormals, kHarmonics = 5;
  template <int Rows>
  using Columns = Eigen::Matrix<double, Rows, Eigen::Dynamic, Eigen::ColMajor, Rows, kMost>;

  Columns<2> foot;                ///< on the ellipse
  Columns<2> direction;           ///< outwards, of length 1
  Columns<Outline::kTerms> move;  ///< along the normal, by a unit of each of the outline's terms
  Columns<kHarmonics> harmonics;  ///< 1, cos a, sin a, cos 2a, sin 2a
  PerNormal arc_px;               ///< of the ellipse, to the next normal

  int count() const { return static_cast<int>(foot.cols()); }

  /// Writes `count` normals, at most kMost.
  void spread(const Outline& outline, int count);

  /// How far the outline moves along each normal by a change of its terms.
  PerNormal moved(const Outline::Terms& terms) const;
  /// How far the outline's waves lie outside its ellipse.
  PerNormal waves(const Outline& outline) const;

 private:
  void spread_harmonics(int count);
};

}  // namespace planar
