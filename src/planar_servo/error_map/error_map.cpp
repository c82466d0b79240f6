#include "planar_servo/error_map/error_map.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace planar {

namespace {

void require_finite(const Eigen::Vector2d& p) {
  if (p.allFinite()) return;
  throw std::invalid_argument("an error map cannot be evaluated at a position that is not finite");
}

Eigen::Vector2d direction_of(std::optional<double> phi) {
  if (phi && std::isfinite(*phi)) return {std::cos(*phi), std::sin(*phi)};
  throw std::invalid_argument("the error map depends on the tool's direction, which is not known");
}

MapKind kind(const IdwMap&) {
  return MapKind::kIdw;
}

MapKind kind(const RbfMap& map) {
  return map.parameters().kernel.shape == KernelShape::kGaussian ? MapKind::kGaussianRbf
                                                                 : MapKind::kMultiquadricRbf;
}

MapKind kind(const SparseRbfMap&) {
  return MapKind::kSparseGaussianRbf;
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

MapKind kind_of(const ErrorMap& map) {
  return std::visit([](const auto& of_kind) { return kind(of_kind); }, map);
}

const char* name(MapKind kind) {
  return name_in(kMapKinds, kind);
}

ErrorPrediction predict(const ErrorMap& map, const Eigen::Vector2d& p_vision,
                        std::optional<double> phi) {
  require_finite(p_vision);
  if (depends_on_direction(map)) return std::get<RbfMap>(map).predict(p_vision, direction_of(phi));
  return std::visit([&](const auto& method) { return method.predict(p_vision); }, map);
}

Eigen::Vector2d predict_error(const ErrorMap& map, const Eigen::Vector2d& p_vision,
                              std::optional<double> phi) {
  require_finite(p_vision);
  if (depends_on_direction(map))
    return std::get<RbfMap>(map).predict_error(p_vision, direction_of(phi));
  return std::visit([&](const auto& method) { return method.predict_error(p_vision); }, map);
}

bool depends_on_direction(const ErrorMap& map) {
  const auto* rbf = std::get_if<RbfMap>(&map);
  return rbf != nullptr && rbf->parameters().tail_basis.with_direction;
}

std::optional<ToolBias> tool_bias(const ErrorMap& map) {
  const auto* rbf = std::get_if<RbfMap>(&map);
  return rbf != nullptr ? rbf->tool_bias() : std::nullopt;
}

double noise_sigma(const ErrorMap& map) {
  return std::visit([](const auto& method) { return noise_of(method); }, map);
}

}  // namespace planar
