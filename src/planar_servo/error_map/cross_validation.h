#pragma once

#include "planar_servo/error_map/error_map.h"
#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/spatial_blocks.h"

namespace planar {

/// What a map is worth in a gap between its sites that is as wide as a block of them.
struct CrossValidation {
  RmsEstimate rms;  ///< of the residuals of each block predicted by the others, metres
  /// Diameter of the widest circle about a site of a block that holds no site of the others, median
  /// over the blocks, metres.
  double gap{0.0};
};

/// Predicts every spatial block of the `sites` that `map` was fitted to from the sites of the other
/// blocks, by a map with the same settings: kernel, width, ridge, and degree of the tail where the
/// others determine it. A sparse map is judged on about ten thousand evenly drawn sites. Throws
/// WorkError when the equations are too ill conditioned to be solved.
CrossValidation cross_validate(const ErrorMap& map, const MapSites& sites);

/// Returns whether a map removes more than 5 % of the rms error at sites that it does not know, and
/// by more than chance. `residuals` are those of the sites when each is left out of the fit. Blocks
/// count as independent draws.
bool is_worth_using(const MapSites& sites, const Eigen::Matrix2Xd& residuals);

}  // namespace planar
