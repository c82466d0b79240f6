#pragma once

#include <optional>
#include <string>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/cell/servo_settings.h"
#include "planar_servo/core/clock.h"
#include "planar_servo/robot/planar_robot.h"
#include "planar_servo/servo/arrival.h"
#include "planar_servo/servo/tip_sensor.h"

namespace planar {

/// Holds what was found of the motors' play.
struct PlayProbe {
  /// The play of motors 1 and 2, radians behind the gear; 0 for motor 3, which the end point does
  /// not show.
  std::optional<Eigen::Vector3d> play_rad{};
  std::string unknown{};  ///< why there is no play, in words
  /// What kept the arm from coming back, from below, to where it rested, if anything did.
  std::optional<Obstacle> not_back{};
};

/// Measures the play where the arm rests: it arrives there with every motor from above and then
/// from below, and looks each time. Nothing moves where the arm must not do that. Looks that differ
/// by more than the approach margin lets play show tell nothing. Throws what PlanarRobot::move_to()
/// throws.
PlayProbe measure_play(PlanarRobot& robot, const JointPlanner& planner,
                       const ServoSettings& settings, TipSensor& sensor, Clock& clock);

}  // namespace planar
