#pragma once

#include <Eigen/Core>

#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/maps/radial_kernel.h"
#include "planar_servo/error_map/maps/tail_basis.h"

namespace planar {

struct TunedKernel {
  RadialKernel kernel;
  double ridge{0.0};  ///< in units of the kernel
  /// How the best ridge changes with the width thereabouts: d log ridge / d log width.
  double slope{0.0};
  double loo_rms{0.0};  ///< rms of what each sample is missed by, its whole site left out, metres
  /// Per site that decided: what its mean is missed by, squared, times its count; square metres.
  Eigen::ArrayXd squared_misses;
};

/// The kernel's width and ridge with the smallest leave-one-out error: a coarse grid over the
/// logarithms of both, on which a hundred sites decide, then BOBYQA [Powell 2009] from its best
/// point. Above five hundred sites an evenly drawn part of them decides.
TunedKernel tune_rbf(const MapSites& sites, const TailBasis& tail_basis, KernelShape shape);

/// The same from what nearly the same sites were tuned to, without the grid.
TunedKernel retune_rbf(const MapSites& sites, const TailBasis& tail_basis,
                       const TunedKernel& before);

}  // namespace planar
