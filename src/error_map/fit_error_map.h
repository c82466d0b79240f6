#pragma once

#include <string>
#include <vector>

#include "error_map/error_map.h"

namespace planar {

enum class MapMethod { kAuto, kRbf, kIdw, kHandWidth };

struct MapProblem {
  std::vector<ErrorSample> samples;
  MapMethod method{MapMethod::kAuto};
  double hand_width{0.0};  ///< metres; only for kHandWidth: no ridge, no tail, as the paper has it
};

struct RejectedSample {
  std::string id;
  double residual{0.0};  ///< leave-one-out residual, metres
  std::string reason;
};

struct MapResult {
  ErrorMap map;
  std::string method;  ///< what was fitted: "rbf", "idw", "hand"
  std::size_t n_used{0};
  std::vector<RejectedSample> rejected;
  double raw_rms{0.0};    ///< rms of |E| over the used samples, metres
  double loo_rms{0.0};    ///< rms of the leave-one-out residuals |r_i| over the used samples, metres
  double noise_sigma{0.0};  ///< per axis, metres; NaN where the method has none
  bool worth_using{false};  ///< the leave-one-out error is significantly below the raw one
};

/// Fits a map to pairs. Throws InputError for non-finite samples, fewer than 3 distinct positions,
/// or more outliers than a bounded share. Duplicates are merged.
MapResult fit_error_map(const MapProblem& problem);

}  // namespace planar
