#pragma once

#include <optional>
#include <string>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/cell/servo_settings.h"
#include "planar_servo/robot/planar_robot.h"

namespace planar {

/// Says what kept the arm from arriving.
struct Obstacle {
  bool refused{false};  ///< the move is forbidden; else the guard stopped the arm on the way
  std::string reason;
};

/// Moves the arm to these joints as the settings say: straight, or with every motor from the same
/// side. Nothing moves when the planner refuses the joints, the place short of them or the
/// way there. Throws what
/// PlanarRobot::move_to() throws.
std::optional<Obstacle> arrive(PlanarRobot& robot, const JointPlanner& planner,
                               const ServoSettings& settings, const Joints& theta,
                               const PlanarRobot::Guard& guard);

}  // namespace planar
