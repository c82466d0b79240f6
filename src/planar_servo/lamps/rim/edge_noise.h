#pragma once

#include <vector>

namespace planar {

/// What is left of an edge point after a fit.
struct EdgeResidual {
  double angle{0.0};     ///< round the centre of the rim, radians
  double distance{0.0};  ///< from the fitted rim
};

/// How many edges along the rim count for one independent edge: 1 + 2 sum_k (1 - k / (reach + 1))
/// rho_k with the autocorrelation rho_k of the residuals in order of their angle [Newey & West
/// 1987]. Edges more than `reach` places apart share no pixels. At most reach + 1; not below 1 / 2,
/// for a short row of residuals does not prove more.
double edges_per_independent(std::vector<EdgeResidual> residuals, int reach);

}  // namespace planar
