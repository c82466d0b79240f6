#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "planar_servo/lamps/detect/blob.h"
#include "planar_servo/lamps/lamp.h"

namespace planar {

/// Which candidates are the two lamps.
struct PairChoice {
  /// kOk, kAmbiguous, kNoLamp, kOneLamp or kWrongDistance.
  LampStatus status{LampStatus::kNoLamp};
  /// Candidates that are lamps 1 and 2 (kOk), or the two lamps in either order (kAmbiguous).
  std::array<std::size_t, 2> index{0, 0};
  /// False when several pairs are possible and no prediction decides between them; then `index` is
  /// the pair whose candidates come first.
  bool is_unique{true};
};

/// Chooses among candidates, given by falling evidence: pairs of the right distance and sizes only;
/// of these the one nearest to the prediction. Which lamp is which follows from the prediction,
/// unless the pair lies across the predicted direction, or from sizes and contrasts, where the
/// lamps differ. Where neither decides or they contradict each other, that remains kAmbiguous.
PairChoice choose_pair(const std::vector<Blob>& candidates, const PairExpectation& expectation);

}  // namespace planar
