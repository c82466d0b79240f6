#pragma once

#include <Eigen/Core>

#include "planar_servo/arm/transmission.h"

namespace planar {

/// The play of each motor's gear while an arm moves to and fro. A gear that was turned upwards last
/// stands where the arm's model has it; turned downwards, it stands higher by its play.
class GearPlay {
 public:
  /// Takes the play (radians, behind the gear) and the joints where every motor has arrived from
  /// below.
  GearPlay(const Transmission& transmission, const Eigen::Vector3d& play_rad, const Joints& theta);

  /// Takes the joints as the drives stand now. Returns those behind the play. Call it so often that
  /// no motor turns back in between (the play operator).
  Joints behind(const Joints& drives);

  /// Returns the joints to be commanded so that those behind the play come to `wanted`, which moves
  /// from call to call.
  Joints command(const Joints& wanted);

 private:
  const Transmission& transmission_;
  Eigen::Vector3d play_;
  Eigen::Vector3d held_;     ///< motors' angles behind the play
  Eigen::Vector3d extreme_;  ///< the farthest that each motor was wanted on its present way
  Eigen::Vector3d side_{1.0, 1.0, 1.0};  ///< +1 for a motor on its way up, -1 down
};

}  // namespace planar
