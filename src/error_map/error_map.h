#pragma once

#include <Eigen/Core>
#include <variant>

#include "error_map/error_sample.h"
#include "error_map/idw.h"
#include "error_map/rbf_map.h"
#include "error_map/sparse_rbf_map.h"

namespace planar {

using ErrorMap = std::variant<IdwMap, RbfMap, SparseRbfMap>;

/// The vision error at p_vision (base frame, metres), which must be a position AS VISION SAW IT.
/// Outside the valid region the map still answers, and says so; what to do then is the caller's
/// decision. Throws std::invalid_argument for a position that is not finite.
ErrorPrediction predict(const ErrorMap& map, const Eigen::Vector2d& p_vision);

/// The error of `predict` alone, without its standard deviation, which takes most of the time.
Eigen::Vector2d predict_error(const ErrorMap& map, const Eigen::Vector2d& p_vision);

/// Standard deviation per axis of the noise that the map found in its samples, metres; NaN where
/// the method has none.
double noise_sigma(const ErrorMap& map);

}  // namespace planar
