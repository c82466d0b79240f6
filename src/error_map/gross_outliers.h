#pragma once

#include <Eigen/Core>
#include <vector>

#include "error_map/map_sites.h"

namespace planar {

/// The sites whose error is anything like the median of their neighbours' errors: a start for finer
/// judgement that even a third of gross outliers does not upset. In order.
std::vector<Eigen::Index> sites_like_their_neighbours(const MapSites& sites);

}  // namespace planar
