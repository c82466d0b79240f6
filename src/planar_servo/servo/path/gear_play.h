#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/arm/transmission.h"
#include "planar_servo/cell/servo_settings.h"
#include "planar_servo/core/clock.h"
#include "planar_servo/robot/planar_robot.h"
#include "planar_servo/servo/approach.h"
#include "planar_servo/servo/tip_sensor.h"

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

/// Holds what was found of the motors' play.
struct PlayProbe {
  /// The play of motors 1 and 2, radians behind the gear; 0 for motor 3, which the end point does
  /// not show.
  std::optional<Eigen::Vector3d> play_rad{};
  std::string unknown{};  ///< why there is no play, in words
  /// What kept the arm from returning, from below, to where it rested, if anything did.
  std::optional<Obstacle> not_back{};
};

/// Measures the play where the arm rests: it arrives there with every motor from above and then
/// from below, and looks each time. Nothing moves where the arm must not do that. Looks that differ
/// by more than the approach margin tell nothing. Throws what PlanarRobot::move_to() throws.
PlayProbe measure_play(PlanarRobot& robot, const JointPlanner& planner,
                       const ServoSettings& settings, TipSensor& sensor, Clock& clock);

}  // namespace planar
