#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace planar {

/// Errors at P1 to P5 in one cycle, metres.
using CycleErrors = std::array<Eigen::Vector2d, 5>;

/// A figure of the first and of the last cycles, and how much chance alone lets the two differ.
struct FirstAndLast {
  double first{0.0}, last{0.0};
  double chance{0.0};  ///< the difference stays below it with kCertainty where nothing drifts
};

/// How accuracy changed during a run. Metres, means over the poses.
struct PoseDrift {
  std::size_t cycles{0};  ///< as many of the first are compared with as many of the last
  double shift{0.0};      ///< of the mean error vector
  double shift_chance{0.0};
  FirstAndLast accuracy;                        ///< AP
  std::optional<FirstAndLast> repeatability{};  ///< RP; needs two cycles on either side
};

/// Compares the first third of the cycles with the last third, at least one cycle each. What chance
/// alone makes is found by changing the order of the cycles. Empty for fewer than two cycles.
std::optional<PoseDrift> pose_drift(const std::vector<CycleErrors>& cycles);

}  // namespace planar
