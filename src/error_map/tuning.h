#pragma once

#include <Eigen/Core>

#include "error_map/tail_basis.h"

namespace planar {

struct TunedKernel {
  double width{0.0};    ///< metres
  double ridge{0.0};    ///< in units of the kernel
  double loo_rms{0.0};  ///< rms of the leave-one-out residuals reached, metres
};

/// The Gaussian's width and ridge with the smallest leave-one-out error: a coarse grid over the
/// logarithms of both, then BOBYQA [Powell 2009] from its best point. Errors (metres) at distinct
/// positions. Above a thousand samples an evenly drawn part of them decides.
TunedKernel tune_gaussian(const Eigen::Matrix2Xd& positions, const Eigen::Matrix2Xd& errors,
                          const TailBasis& tail_basis);

}  // namespace planar
