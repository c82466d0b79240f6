#pragma once

#include "planar_servo/error_map/error_map.h"
#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/judge/spatial_blocks.h"

namespace planar {

struct CrossValidation {
  RmsEstimate rms;  ///< of what the samples of each block are missed by, metres
  /// The map takes away more than 5 % of the rms error, and by more than chance: block by block, so
  /// that no site is vouched for by its neighbours.
  bool worth_using{false};
};

/// Predicts every spatial block of the `sites` that `map` was fitted to by a map with the same
/// settings (kernel, width, ridge, degree of the tail where the others determine it) of the sites
/// of the other blocks. Of a sparse
/// map about ten thousand evenly drawn sites take part. Throws WorkError when the equations are too
/// ill conditioned to be solved.
CrossValidation cross_validate(const ErrorMap& map, const MapSites& sites);

}  // namespace planar
