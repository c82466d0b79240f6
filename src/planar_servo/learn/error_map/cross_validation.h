#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/learn/error_map/error_map.h"
#include "planar_servo/learn/error_map/fit/map_sites.h"

namespace planar {

/// The sites of each block; every site is in one block.
using Blocks = std::vector<std::vector<Eigen::Index>>;

/// Divides the positions into at most twenty compact blocks of about equally many sites, at least
/// five where that leaves five blocks, by halving across the longer side of their box.
Blocks spatial_blocks(const Eigen::Matrix2Xd& positions);

/// A root mean square and its 95 % confidence interval, metres.
struct RmsEstimate {
  double value{0.0}, low{0.0}, high{0.0};
};

/// Estimates the rms, over all samples, of deviations whose mean at each site is a column of
/// `means`. As neighbours may err together, blocks count as independent draws. The interval is
/// Student's t over the blocks for the logarithm of the mean square.
RmsEstimate estimate_rms(const MapSites& sites, const Eigen::Matrix2Xd& means,
                         const Blocks& blocks);

/// Returns whether the sum of one value per block is above zero by more than chance: with signs
/// drawn at random it is as large in at most one of twenty draws [Fisher 1935]. At most kMostBlocks
/// values; fewer than five are never enough.
bool is_clearly_positive(const Eigen::ArrayXd& values_of_blocks);

/// Returns the two-sided 95 % quantile of Student's t with n >= 2 degrees of freedom [Abramowitz
/// and Stegun 26.7.5].
double student_t_95(Eigen::Index n);

/// The worth of a map in a gap between its sites as wide as a block of them.
struct CrossValidation {
  RmsEstimate rms;  ///< of the residuals of each block predicted by the others, metres
  /// Diameter of the widest circle about a site of a block without other sites, median, metres.
  double gap{0.0};
};

/// Predicts every spatial block of the `sites` that `map` was fitted to from the others, by a map
/// with the same kernel, width, ridge, and degree of the tail where they determine it; a sparse map
/// on about ten thousand of them. Throws WorkError when the equations are too ill conditioned.
CrossValidation cross_validate(const ErrorMap& map, const MapSites& sites);

/// Returns whether a map removes more than 5 % of the rms error at sites that it does not know, and
/// by more than chance over the blocks. `residuals` are those of the sites when each is left out.
bool is_worth_using(const MapSites& sites, const Eigen::Matrix2Xd& residuals);

}  // namespace planar
