#include "planar_servo/error_map/map_quality.h"

#include <fmt/format.h>

#include <cmath>

#include "planar_servo/core/statistics.h"

namespace planar {

int components_within_95(const Eigen::Vector2d& miss, const Eigen::Vector2d& sigma) {
  return static_cast<int>((miss.array().abs() <= 1.96 * sigma.array()).count());
}

std::optional<Refusal> objection(const MapQuality& quality) {
  constexpr double kLeastCoverage = 0.8;
  if (quality.n == 0) return std::nullopt;
  if (!quality.worth_using)
    return Refusal{
        "its fit says not to use it: between its places it removes too little of the error, or no "
        "more than chance would"};
  const auto components = static_cast<int>(2 * quality.n);
  const auto within = static_cast<int>(std::lround(quality.coverage_95 * components));
  if (binomial_tail(within, components, kLeastCoverage) >= kFalseAlarm) return std::nullopt;
  return Refusal{fmt::format(
      "only {:.0f} % of what {} places left out show lies within its stated 95 %: something moved "
      "while it was recorded, or readings scatter more than the cell file states",
      100.0 * quality.coverage_95, quality.n)};
}

}  // namespace planar
