#include "error_map/error_map.h"

#include <limits>
#include <stdexcept>

namespace planar {

ErrorPrediction predict(const ErrorMap& map, const Eigen::Vector2d& p_vision) {
  if (!p_vision.allFinite()) {
    throw std::invalid_argument(
        "an error map cannot be evaluated at a position that is not finite");
  }
  return std::visit([&](const auto& method) { return method.predict(p_vision); }, map);
}

double noise_sigma(const ErrorMap& map) {
  const auto* rbf = std::get_if<RbfMap>(&map);
  return rbf && rbf->parameters().ridge > 0.0 ? rbf->noise_sigma()
                                              : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace planar
