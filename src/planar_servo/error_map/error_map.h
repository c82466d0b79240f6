#pragma once

#include <Eigen/Core>
#include <optional>
#include <variant>

#include "planar_servo/error_map/error_sample.h"
#include "planar_servo/error_map/maps/idw_map.h"
#include "planar_servo/error_map/maps/rbf_map.h"
#include "planar_servo/error_map/maps/sparse_rbf_map.h"

namespace planar {

using ErrorMap = std::variant<IdwMap, RbfMap, SparseRbfMap>;

/// The vision error at p_vision (base frame, metres), which must be a position AS VISION SAW IT.
/// Outside the valid region the map still answers, and says so; what to do then is the caller's
/// decision. `phi` is the tool's orientation in the base frame, radians; only a map that depends on
/// it needs it. Throws std::invalid_argument for a position that is not finite, and for a phi that
/// is needed and not given or not finite.
ErrorPrediction predict(const ErrorMap& map, const Eigen::Vector2d& p_vision,
                        std::optional<double> phi = std::nullopt);

/// The error of `predict` alone, without its standard deviation, which takes most of the time.
Eigen::Vector2d predict_error(const ErrorMap& map, const Eigen::Vector2d& p_vision,
                              std::optional<double> phi = std::nullopt);

/// Whether predictions depend on the tool's direction.
bool depends_on_direction(const ErrorMap& map);

/// The error fixed in the tool's frame that the map found; empty where it found none.
std::optional<ToolBias> tool_bias(const ErrorMap& map);

/// Standard deviation per axis of the noise that the map found in its samples, metres; NaN where
/// the method has none.
double noise_sigma(const ErrorMap& map);

}  // namespace planar
