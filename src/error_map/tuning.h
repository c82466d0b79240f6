#pragma once

#include "error_map/map_sites.h"
#include "error_map/tail_basis.h"

namespace planar {

struct TunedKernel {
  double width{0.0};    ///< metres
  double ridge{0.0};    ///< in units of the kernel
  double loo_rms{0.0};  ///< rms of what each sample is missed by, its whole site left out, metres
};

/// The Gaussian's width and ridge with the smallest leave-one-out error: a coarse grid over the
/// logarithms of both, then BOBYQA [Powell 2009] from its best point. Above a thousand sites an
/// evenly drawn part of them decides.
TunedKernel tune_gaussian(const MapSites& sites, const TailBasis& tail_basis);

}  // namespace planar
