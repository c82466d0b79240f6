#pragma once

#include <string>
#include <vector>

#include "planar_servo/base/core/operator.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/learn/error_map/cross_validation.h"
#include "planar_servo/learn/error_map/fit_error_map.h"

namespace planar {

/// The width of the paper's Gaussian.
constexpr double kPaperWidth = 48.0 * kMillimetre;

/// How well a method predicts the pairs that the fit kept, metres.
struct MethodFigures {
  std::string method;   ///< "raw" (no map), or the name that --method takes
  double loo_rms{0.0};  ///< NaN when the method's equations cannot be solved for these pairs
  RmsEstimate blocked;  ///< as CrossValidation::rms
};

/// Judges raw, idw, hand (kPaperWidth if the problem has none), rbf and auto on the samples that
/// `result` has used; beyond kMostDense positions only raw and the result's own method.
std::vector<MethodFigures> compare_methods(const MapProblem& problem, const MapResult& result,
                                           const Progress& progress = {});

}  // namespace planar
