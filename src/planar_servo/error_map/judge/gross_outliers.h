#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/error_map/fit/map_sites.h"

namespace planar {

/// Of each site the sites nearest to it, at most a dozen, itself not among them.
using Neighbours = std::vector<std::vector<Eigen::Index>>;
Neighbours nearest_sites(const MapSites& sites);

/// The sites whose error is anything like the median of their neighbours' errors: a start for finer
/// judgement that even a third of gross outliers does not upset. In order.
std::vector<Eigen::Index> sites_like_their_neighbours(const MapSites& sites,
                                                      const Neighbours& neighbours);

}  // namespace planar
