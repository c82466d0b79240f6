#pragma once

#include <string>
#include <vector>

#include "planar_servo/core/progress.h"
#include "planar_servo/core/units.h"
#include "planar_servo/error_map/fit_error_map.h"
#include "planar_servo/error_map/judge/spatial_blocks.h"

namespace planar {

/// The width of the paper's Gaussian.
constexpr double kPaperWidth = 48.0 * kMillimetre;

/// How well a method predicts the pairs that the fit kept; lengths in metres.
struct MethodFigures {
  std::string method;   ///< "raw" (no map), or as --method names it
  double loo_rms{0.0};  ///< NaN when the method's equations cannot be solved for these pairs
  RmsEstimate blocked;  ///< as `CrossValidation::rms`
};

/// Every method on the samples that `result`, fitted to `problem`, has used, from none to the most
/// able: raw, idw, hand (with kPaperWidth where the problem names no width), rbf, auto. Beyond a
/// thousand positions only raw and the result's own.
std::vector<MethodFigures> compare_methods(const MapProblem& problem, const MapResult& result,
                                           const Progress& progress = {});

}  // namespace planar
