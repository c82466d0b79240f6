#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "planar_servo/core/progress.h"
#include "planar_servo/error_map/error_map.h"
#include "planar_servo/error_map/judge/cell_diagnosis.h"
#include "planar_servo/error_map/judge/spatial_blocks.h"

namespace planar {

enum class MapMethod {
  kAuto,       ///< multiquadric on a quadratic tail, or Gaussian on a cubic one where that is
               ///< clearly better by the leave-one-out error; otherwise as kRbf. Beyond
               ///< kMostDense positions a sparse Gaussian
  kRbf,        ///< Gaussian on a linear tail, width and ridge tuned on the leave-one-out error,
               ///< outliers left out
  kIdw,        ///< every sample as it is, as the paper has it
  kHandWidth,  ///< every sample as it is, Gaussian without ridge and tail, as the paper has it
};

struct MapProblem {
  std::vector<ErrorSample> samples;
  MapMethod method{MapMethod::kAuto};
  double hand_width{0.0};  ///< metres; only for kHandWidth
};

/// A dense map of more positions takes more time than it is worth; they go to a sparse one.
constexpr Eigen::Index kMostDense = 1000;

struct RejectedSample {
  std::size_t index{0};  ///< among the problem's samples
  std::string id;
  double residual{0.0};  ///< distance from what the samples that were kept predict there, metres
  std::string reason;
};

/// Lengths in metres; rms values are over the samples used. Samples at one position are left out
/// together, so that a repeated row cannot vouch for itself.
struct MapResult {
  ErrorMap map;
  std::string method;     ///< what was fitted: "rbf", "multiquadric", "sparse", "idw", "hand"
  std::size_t n_used{0};  ///< samples
  std::vector<RejectedSample> rejected;
  double raw_rms{0.0};      ///< of |E|
  double loo_rms{0.0};      ///< of the leave-one-out residuals |r_i|
  double idw_loo_rms{0.0};  ///< the same of inverse distance weighting; NaN for a sparse map
  double noise_sigma{0.0};  ///< per axis; NaN where the method has none
  RmsEstimate blocked;      ///< the rms with whole blocks of neighbours left out, and its interval
  /// As `CrossValidation::worth_using`: more than 5 % of the rms error, and not by chance.
  bool worth_using{false};
  CellDiagnosis cell;  ///< what the pairs say of the cell; no part of the map

  /// 1 - loo_rms / raw_rms; 0 when there is no error to begin with.
  double gain() const { return raw_rms > 0.0 ? 1.0 - loo_rms / raw_rms : 0.0; }
};

/// Fits a map to pairs. Samples at one position are averaged. kAuto and kRbf, where they are dense,
/// take the tool's direction into the tail if every sample names it and the leave-one-out error
/// says so (as `tune` of families). Throws InputError for samples that
/// are not finite or not in metres (`require_one_unit`), fewer than 3 distinct positions, more than
/// kMostDense but for kAuto, a hand width that is not positive, or outliers beyond a fifth of the
/// samples; WorkError when the equations are too ill conditioned to be solved.
MapResult fit_error_map(const MapProblem& problem, const Progress& progress = {});

}  // namespace planar
