#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "planar_servo/core/error.h"

namespace planar {

/// What the places that a fit left out say of its map.
struct MapQuality {
  std::size_t n{0};  ///< places that judge it; none where there was no tracker
  bool worth_using{false};
  double coverage_95{0.0};  ///< share of their components within 1.96 stated deviations
};

/// Returns how many of the two components lie within 1.96 of their deviations.
int components_within_95(const Eigen::Vector2d& miss, const Eigen::Vector2d& sigma);

/// Says why no arm should move by a map; empty where nothing speaks against it. A share within the
/// stated 95 % speaks against it when it is below 80 % and chance makes it so in less than one of a
/// thousand maps that reach 80 %.
std::optional<Refusal> objection(const MapQuality& quality);

}  // namespace planar
