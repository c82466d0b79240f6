#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "planar_servo/error_map/error_sample.h"

namespace planar {

/// Calibration points at distinct positions, as columns of matrices.
struct MapSites {
  Eigen::Matrix2Xd positions;  ///< metres
  Eigen::Matrix2Xd errors;     ///< mean error of the samples at each position, metres
  Eigen::VectorXd counts;      ///< samples merged into each
  Eigen::VectorXd scatter;     ///< sum over these of |E - mean|^2, square metres
  std::vector<std::vector<std::size_t>> samples;  ///< which samples these are
  /// Standard deviation of a sample per axis as the instruments state it, rms over all, metres; 0
  /// where some are silent. No map can have found less noise.
  double stated_sigma{0.0};
  /// (cos phi, sin phi) of the tool, mean over the samples at each position; no columns unless
  /// every sample names its phi.
  Eigen::Matrix2Xd directions;

  Eigen::Index size() const { return positions.cols(); }
  MapSites subset(const std::vector<Eigen::Index>& kept) const;
  /// The first site and each `stride` further on.
  MapSites every(Eigen::Index stride) const;
  bool has_directions() const { return directions.cols() > 0; }
  /// NaN where there are none.
  Eigen::Vector2d direction(Eigen::Index site) const;

  /// Root mean square over all samples of deviations whose mean at each site is a column of
  /// `means`.
  double sample_rms(const Eigen::Matrix2Xd& means) const;
};

/// Merges samples closer together than any camera can tell apart, whatever the tool's direction: a
/// position is left out as a whole, and a term linear in the direction has the mean error at the
/// mean direction. Throws InputError naming each sample that is not finite, or when fewer than
/// three distinct positions remain.
MapSites merge_samples(const std::vector<ErrorSample>& samples);

}  // namespace planar
