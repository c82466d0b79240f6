#pragma once

#include "planar_servo/error_map/error_map.h"
#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/judge/spatial_blocks.h"

namespace planar {

struct CrossValidation {
  RmsEstimate rms;  ///< of the residuals of each block predicted by the others, metres
  /// Whether the map removes more than 5 % of the rms error, and by more than chance. Blocks are
  /// compared, so that no site is confirmed by its neighbours.
  bool worth_using{false};
};

/// Predicts every spatial block of the `sites` that `map` was fitted to from the sites of the other
/// blocks, by a map with the same settings: kernel, width, ridge, and degree of the tail where the
/// others determine it. A sparse map is judged on about ten thousand evenly drawn sites. Throws
/// WorkError when the equations are too ill conditioned to be solved.
CrossValidation cross_validate(const ErrorMap& map, const MapSites& sites);

}  // namespace planar
