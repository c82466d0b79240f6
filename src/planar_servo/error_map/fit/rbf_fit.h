#pragma once

#include <Eigen/Core>

#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/maps/rbf_map.h"

namespace planar {

class BorderedSystem;

/// Residuals of the samples when each in turn is left out of the fit, computed without refitting.
struct LeaveOneOut {
  Eigen::Matrix2Xd residuals;  ///< E_i minus the prediction of the others, one column each
  Eigen::VectorXd
      unit_sigmas;  ///< standard deviation of a residual divided by s_f: 1 / sqrt((A^-1)_ii)
};

/// Computes r_i = w_i / (A^-1)_ii for the bordered matrix A and its weights w [Rippa 1999].
LeaveOneOut leave_one_out(const BorderedSystem& system, const Eigen::Matrix2Xd& weights);

/// Returns the standard error of the sum of independent draws, of which there are at least two.
double standard_error_of_sum(const Eigen::ArrayXd& draws);

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
