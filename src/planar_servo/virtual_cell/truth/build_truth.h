#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace planar {

/// Names of monuments with their places in the base frame, metres.
using VirtualMonuments = std::vector<std::pair<std::string, Eigen::Vector3d>>;

/// How arm and drives are built and where the monuments stand, whatever cell.yaml states. What is
/// empty is as cell.yaml states it.
struct BuildTruth {
  std::optional<double> sense;                  ///< +1 counterclockwise, -1 clockwise
  std::optional<std::array<bool, 2>> relative;  ///< whether motors 2 and 3 ride on the link before
  std::optional<Eigen::Vector3d> gear_ratios;   ///< motor turns per joint turn
  std::optional<Eigen::Vector3d> directions;    ///< each +1 or -1
  /// Joint angles at power-up and at the home switches, where the drives count what cell.yaml
  /// states for its home.
  std::optional<Eigen::Vector3d> home_rad;
  VirtualMonuments monuments_B;
};

}  // namespace planar
