#pragma once

#include <cstddef>
#include <vector>

#include "planar_servo/field/joint_estimate.h"

namespace planar {

/// Says where the next tracker readings tell most, and the end point's uncertainty with them.
struct NextPlaces {
  std::vector<std::size_t> chosen;  ///< among the candidates, the most telling first
  /// Standard deviation per axis of the compensated end point, mean over the candidates, metres:
  /// before any of the chosen is read, and after each of them; `first` is read by then.
  std::vector<double> sigmas;
};

/// Chooses up to `count` of the candidates, one after the other, each where the end point is least
/// certain by then. The poses `first` are read before them in any case. A candidate is a pose with
/// the deviations that its reading and its lamps would have. Linear Gaussian theory: what is read
/// does not matter, only where.
NextPlaces choose_next_places(const JointEstimate& estimate,
                              const std::vector<PoseSample>& candidates, std::size_t count,
                              const std::vector<PoseSample>& first = {});

}  // namespace planar
