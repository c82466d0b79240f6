#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/error_map/fit/map_sites.h"

namespace planar {

/// For each site the sites nearest to it, at most a dozen, without itself.
using Neighbours = std::vector<std::vector<Eigen::Index>>;
Neighbours nearest_sites(const MapSites& sites);

/// Returns, in order, the sites whose error is roughly the median of their neighbours' errors. It
/// is a start for finer judgement that withstands up to a third of gross outliers.
std::vector<Eigen::Index> sites_like_their_neighbours(const MapSites& sites,
                                                      const Neighbours& neighbours);

}  // namespace planar
