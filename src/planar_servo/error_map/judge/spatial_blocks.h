#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/error_map/fit/map_sites.h"

namespace planar {

/// Sites that lie together, per block; every site in one of them.
using Blocks = std::vector<std::vector<Eigen::Index>>;

/// At most twenty compact blocks of about as many sites each: the positions halved across the
/// longer side of their box, and so on. At least five sites a block where that leaves five blocks.
Blocks spatial_blocks(const Eigen::Matrix2Xd& positions);

/// A root mean square and its 95 % confidence interval, metres.
struct RmsEstimate {
  double value{0.0};
  double low{0.0};
  double high{0.0};
};

/// Of deviations whose mean at each site is a column of `means`, over all samples. Neighbours may
/// be wrong together, so that blocks, not sites, count as independent draws: Student's t over them,
/// of the logarithm of the mean square, which stays positive.
RmsEstimate estimate_rms(const MapSites& sites, const Eigen::Matrix2Xd& means,
                         const Blocks& blocks);

/// Whether the sum of one value per block is above zero by more than its uncertainty (one value per
/// block, two-sided 95 % of Student's t); not with fewer than three blocks.
bool is_clearly_positive(const Eigen::ArrayXd& values_of_blocks);

/// What the estimate of a mean from n + 1 draws is off by in one of twenty cases, over its standard
/// error; n at least 2 [Abramowitz and Stegun 26.7.5].
double student_t_95(Eigen::Index n);

}  // namespace planar
