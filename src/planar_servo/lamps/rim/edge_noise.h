#pragma once

#include <vector>

namespace planar {

/// The residual of an edge point after a fit.
struct EdgeResidual {
  double angle{0.0};     ///< of the point round the rim's centre, radians
  double distance{0.0};  ///< of the point from the fitted rim
};

/// Returns how many edges along the rim count as one independent edge: 1 + 2 sum_k (1 - k / (reach
/// + 1)) rho_k, with the autocorrelation rho_k of the residuals in order of their angle [Newey &
/// West 1987]. Edges more than `reach` apart in this order share no pixels. The result lies between
/// 1 / 2 and reach + 1, because a short row of residuals proves no less.
double edges_per_independent(std::vector<EdgeResidual> residuals, int reach);

}  // namespace planar
