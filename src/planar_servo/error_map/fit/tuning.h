#pragma once

#include <Eigen/Core>

#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/maps/rbf_basis.h"

namespace planar {

struct TunedKernel {
  RadialKernel kernel;
  double ridge{0.0};  ///< in units of the kernel
  /// Change of the best ridge with the width there: d log ridge / d log width.
  double slope{0.0};
  double loo_rms{0.0};  ///< leave-one-out error over all samples, metres
  /// Squared leave-one-out error of each site that decided, times its count; square metres.
  Eigen::ArrayXd squared_misses;
};

/// Chooses the kernel's width and ridge with the smallest leave-one-out error: by a coarse grid
/// over the logarithms of both on a hundred sites, then by BOBYQA [Powell 2009] from its best
/// point. At most five hundred evenly drawn sites decide.
TunedKernel tune_rbf(const MapSites& sites, const TailBasis& tail_basis, KernelShape shape);

/// Tunes to sites that are nearly those of `before`, starting from its kernel, without the grid.
TunedKernel retune_rbf(const MapSites& sites, const TailBasis& tail_basis,
                       const TunedKernel& before);

}  // namespace planar
