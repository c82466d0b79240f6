#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "planar_servo/learn/error_map/error_sample.h"

namespace planar {

/// Calibration points merged by place or position (sites), as columns of matrices.
struct MapSites {
  Eigen::Matrix2Xd positions;  ///< metres
  Eigen::Matrix2Xd errors;     ///< mean error of the samples at each site, metres
  Eigen::VectorXd counts;      ///< number of samples merged into each site
  Eigen::VectorXd scatter;     ///< sum of |E - mean|^2 over a site's samples, square metres
  std::vector<std::vector<std::size_t>> samples;  ///< indices of each site's samples
  /// Standard deviation of a sample per axis as the instruments state it, rms over all samples,
  /// metres; 0 if some do not state it. No map should find less noise.
  double stated_sigma{0.0};
  /// Mean (cos phi, sin phi) of the tool at each site; no columns unless every sample has a phi.
  Eigen::Matrix2Xd directions;
  /// The share of a sample's noise variance that it has in common with the others of its site: 0 if
  /// they are wrong independently of each other, 1 if all are wrong alike.
  double place_share{0.0};

  Eigen::Index size() const { return positions.cols(); }
  MapSites subset(const std::vector<Eigen::Index>& kept) const;
  /// Returns the first site and every `stride`-th one after it.
  MapSites every(Eigen::Index stride) const;
  bool has_directions() const { return directions.cols() > 0; }
  /// Returns the tool's mean direction at a site, or NaN where directions are unknown.
  Eigen::Vector2d direction(Eigen::Index site) const;
  /// Returns the number of independent samples whose mean would be as noisy as that of each site.
  Eigen::VectorXd weights() const { return weights_for(counts); }
  Eigen::VectorXd weights_for(const Eigen::VectorXd& of_counts) const;
  /// Returns the rms over all samples of deviations whose mean at each site is in `means`.
  double sample_rms(const Eigen::Matrix2Xd& means) const;
};

/// Merges the samples of each named place, and of the others those closer together than any camera
/// can tell, whatever the tool's direction: a term linear in it has its mean at the mean direction.
/// Throws InputError naming each sample that is not finite, or when fewer than three sites remain.
MapSites merge_samples(const std::vector<ErrorSample>& samples);
/// Merges only the samples that are `used`.
MapSites merge_samples(const std::vector<ErrorSample>& samples, const std::vector<bool>& used);

/// Returns whether any sample names its place.
bool names_places(const std::vector<ErrorSample>& samples);

/// Gives samples that lie close together a place of their own, if the positions fall into such
/// groups: in the shortest tree that joins all positions, lengths within a place and between places
/// then differ by a factor of two at least. Returns the samples unchanged if they do not, as on a
/// grid, on rings or at random positions, and beyond five thousand positions. `sites` are the
/// samples merged by position; no sample names a place.
std::vector<ErrorSample> with_found_places(std::vector<ErrorSample> samples, const MapSites& sites);

}  // namespace planar
