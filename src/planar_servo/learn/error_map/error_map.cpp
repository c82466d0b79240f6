#include "planar_servo/learn/error_map/error_map.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "planar_servo/base/core/statistics.h"

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

}  // namespace

MapKind kind_of(const ErrorMap& map) {
  if (std::holds_alternative<IdwMap>(map)) return MapKind::kIdw;
  const auto* dense = std::get_if<RbfMap>(&map);
  if (dense == nullptr) return MapKind::kSparseGaussianRbf;
  return dense->parameters().kernel.shape == KernelShape::kGaussian ? MapKind::kGaussianRbf
                                                                    : MapKind::kMultiquadricRbf;
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

const ValidRegion& valid_region(const ErrorMap& map) {
  if (const auto* idw = std::get_if<IdwMap>(&map)) return idw->region;
  if (const auto* rbf = std::get_if<RbfMap>(&map)) return rbf->parameters().region;
  return std::get<SparseRbfMap>(map).parameters().region;
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
  return std::visit([](const auto& method) { return method.noise_sigma(); }, map);
}

int components_within_95(const Eigen::Vector2d& miss, const Eigen::Vector2d& sigma) {
  return static_cast<int>((miss.array().abs() <= 1.96 * sigma.array()).count());
}

std::optional<Refusal> objection(const MapQuality& quality) {
  constexpr double kLeastCoverage = 0.8;
  if (quality.contradicting > kMostContradicting)
    return Refusal{
        fmt::format("{:.0f} % of its poses contradict the others, while at most {:.0f} % may: "
                    "pictures, readings and commanded joints may not be of one recording, or the "
                    "arm may have lost its position",
                    100.0 * quality.contradicting, 100.0 * kMostContradicting),
        "", "", Cause::kContradiction};
  if (quality.n == 0) return std::nullopt;
  if (!quality.worth_using)
    return Refusal{
        "its fit says not to use it: between its places it removes too little of the error, or no "
        "more than chance would",
        "", "", Cause::kInsufficient};
  const auto components = static_cast<int>(2 * quality.n);
  const auto within = static_cast<int>(std::lround(quality.coverage_95 * components));
  if (binomial_tail(within, components, kLeastCoverage) >= kFalseAlarm) return std::nullopt;
  return Refusal{
      fmt::format("only {:.0f} % of what {} places left out show lies within its stated 95 %: "
                  "something moved while it was recorded, or readings scatter more than the cell "
                  "file states",
                  100.0 * quality.coverage_95, quality.n),
      "", "", Cause::kContradiction};
}

}  // namespace planar
