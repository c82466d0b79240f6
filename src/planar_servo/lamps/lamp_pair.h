#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "planar_servo/lamps/blob.h"
#include "planar_servo/lamps/lamp.h"

namespace planar {

/// Says which candidates are the two lamps.
struct PairChoice {
  /// kOk, kAmbiguous, kNoLamp, kOneLamp or kWrongDistance.
  LampStatus status{LampStatus::kNoLamp};
  /// Lamps 1 and 2 (kOk), or the two lamps in either order (kAmbiguous).
  std::array<std::size_t, 2> index{0, 0};
  /// False when several pairs are possible and no prediction decides between them. `index` is then
  /// the first of these pairs.
  bool is_unique{true};
};

/// Chooses the two lamps among candidates that are given by falling evidence. Of the pairs with the
/// right distance and sizes it takes the one nearest to the prediction. Which lamp is which follows
/// from the predicted direction, unless the pair lies across it, and from sizes and contrasts where
/// the lamps differ. The pair stays kAmbiguous when these contradict each other or say nothing.
PairChoice choose_pair(const std::vector<Blob>& candidates, const PairExpectation& expectation);

}  // namespace planar
