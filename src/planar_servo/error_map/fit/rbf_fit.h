#pragma once

#include <Eigen/Core>

#include "planar_servo/error_map/fit/leave_one_out.h"
#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/maps/rbf_map.h"

namespace planar {

/// Returns s_f^2 = E^T w / (N - m) per axis over all N samples, for the weights of a fit whose tail
/// has m terms. Samples averaged at a site scatter about it with variance ridge s_f^2; where they
/// share a part of their noise, only sites count.
double signal_variance(const MapSites& sites, const Eigen::Matrix2Xd& weights, Eigen::Index terms,
                       double ridge);

struct RbfFit {
  RbfMap map;
  LeaveOneOut left_out;
};

/// Fits a map to sites with given kernel, ridge and tail. Throws WorkError when the kernel matrix
/// is too ill conditioned to be solved.
RbfFit fit_rbf(const MapSites& sites, const TailBasis& tail_basis, const RadialKernel& kernel,
               double ridge);

}  // namespace planar
