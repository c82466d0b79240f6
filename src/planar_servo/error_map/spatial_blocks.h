#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/error_map/fit/map_sites.h"

namespace planar {

/// The sites of each block; every site is in one block.
using Blocks = std::vector<std::vector<Eigen::Index>>;

/// Divides the positions into at most twenty compact blocks of about equally many sites, by halving
/// across the longer side of their box. A block has at least five sites where that leaves five
/// blocks.
Blocks spatial_blocks(const Eigen::Matrix2Xd& positions);

/// A root mean square and its 95 % confidence interval, metres.
struct RmsEstimate {
  double value{0.0};
  double low{0.0};
  double high{0.0};
};

/// Estimates the rms, over all samples, of deviations whose mean at each site is a column of
/// `means`. Neighbours may err together, so blocks, not sites, count as independent draws. The
/// interval is Student's t over the blocks for the logarithm of the mean square, so that it stays
/// positive.
RmsEstimate estimate_rms(const MapSites& sites, const Eigen::Matrix2Xd& means,
                         const Blocks& blocks);

/// Returns whether the sum of one value per block is above zero by more than chance: with signs
/// drawn at random it is as large in at most one of twenty draws [Fisher 1935]. Blocks of which
/// some weigh far more than others do not hide a gain that all of them show. At most kMostBlocks
/// values; fewer than five are never enough.
bool is_clearly_positive(const Eigen::ArrayXd& values_of_blocks);

/// Returns the two-sided 95 % quantile of Student's t with n >= 2 degrees of freedom [Abramowitz
/// and Stegun 26.7.5].
double student_t_95(Eigen::Index n);

}  // namespace planar
