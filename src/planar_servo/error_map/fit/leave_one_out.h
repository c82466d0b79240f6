#pragma once

#include <Eigen/Core>

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

}  // namespace planar
