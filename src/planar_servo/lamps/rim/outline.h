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

}  // namespace planar
