#pragma once

#include <Eigen/Core>
#include <vector>

namespace planar {

/// The share of a reducer's error that comes back h times a turn: a sin(h m) + b cos(h m).
struct ReducerHarmonic {
  Eigen::Vector3d sine{0.0, 0.0, 0.0}, cosine{0.0, 0.0, 0.0};  ///< of motors 1 to 3, radians
};

/// An arm as its poses showed it. With motor angles m (behind the gears, radians), the outputs are
///
///     o = m + z + sum_h (a_h sin(h m) + b_h cos(h m)),   theta = C^-1 o.
struct FoundArm {
  Eigen::Vector2d link_lengths_m{0.3, 0.3};
  Eigen::Vector3d zero_offsets_rad{0.0, 0.0, 0.0};  ///< z
  std::vector<ReducerHarmonic> harmonics;           ///< of order 1, 2, ...
};

/// Returns o.
Eigen::Vector3d reducer_outputs(const FoundArm& arm, const Eigen::Vector3d& motors);

/// Returns the m whose outputs are `outputs`, radians. Reducers err by far less than they turn.
Eigen::Vector3d motors_for_outputs(const FoundArm& arm, const Eigen::Vector3d& outputs);

}  // namespace planar
