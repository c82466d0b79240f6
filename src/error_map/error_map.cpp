#include "error_map/error_map.h"

#include <limits>
#include <stdexcept>

namespace planar {

namespace {

void require_finite(const Eigen::Vector2d& p) {
  if (p.allFinite()) return;
  throw std::invalid_argument("an error map cannot be evaluated at a position that is not finite");
}

double noise_of(const IdwMap&) {
  return std::numeric_limits<double>::quiet_NaN();
}

double noise_of(const RbfMap& map) {
  const bool has_ridge = map.parameters().ridge > 0.0;
  return has_ridge ? map.noise_sigma() : std::numeric_limits<double>::quiet_NaN();
}

double noise_of(const SparseRbfMap& map) {
  return map.noise_sigma();
}

}  // namespace

ErrorPrediction predict(const ErrorMap& map, const Eigen::Vector2d& p_vision) {
  require_finite(p_vision);
  return std::visit([&](const auto& method) { return method.predict(p_vision); }, map);
}

Eigen::Vector2d predict_error(const ErrorMap& map, const Eigen::Vector2d& p_vision) {
  require_finite(p_vision);
  return std::visit([&](const auto& method) { return method.predict_error(p_vision); }, map);
}

double noise_sigma(const ErrorMap& map) {
  return std::visit([](const auto& method) { return noise_of(method); }, map);
}

}  // namespace planar
