#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "marker/lamp.h"

namespace planar {

/// Which candidates are the two lamps.
struct PairChoice {
  /// kOk, kAmbiguous, kNoLamp, kOneLamp or kWrongDistance.
  LampStatus status{LampStatus::kNoLamp};
  /// Candidates that are lamps 1 and 2 (kOk), or the two lamps in either order (kAmbiguous).
  std::array<std::size_t, 2> index{0, 0};
  /// False when several pairs have the right distance and no prediction decides between them; then
  /// `index` is the pair whose candidates come first.
  bool is_unique{true};
};

/// Chooses among candidates, given by falling evidence: pairs of the right distance only; of these
/// the one nearest to the prediction, which also says which lamp is which. Without a prediction, or
/// when the pair lies across the predicted direction, that remains kAmbiguous.
PairChoice choose_pair(const std::vector<Eigen::Vector2d>& candidates_px,
                       const PairExpectation& expectation);

}  // namespace planar
