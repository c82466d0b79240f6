#pragma once

#include <Eigen/Core>

#include "planar_servo/error_map/numerics/bordered_system.h"

namespace planar {

/// What each sample would be missed by, were it left out of the fit, without refitting.
struct LeaveOneOut {
  Eigen::Matrix2Xd residuals;  ///< E_i minus the prediction of the others, one column each
  Eigen::VectorXd
      unit_sigmas;  ///< standard deviation of a residual over s_f (theory: 1/sqrt(A^-1_ii))
};

/// r_i = w_i / (A^-1)_ii for the bordered matrix A and its weights w [Rippa 1999].
LeaveOneOut leave_one_out(const BorderedSystem& system, const Eigen::Matrix2Xd& weights);

/// Standard error of the sum of independent draws; at least two.
double standard_error_of_sum(const Eigen::ArrayXd& draws);

}  // namespace planar
