#pragma once

#include <optional>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/cell/servo_settings.h"
#include "planar_servo/core/clock.h"
#include "planar_servo/robot/planar_robot.h"
#include "planar_servo/servo/tip_sensor.h"

namespace planar {

/// Measures the play of motors 1 and 2 where the arm rests (radians, behind the gear; 0 for motor
/// 3, which the end point does not show): it arrives there with every motor from above and then
/// from below, and looks each time. Empty where the arm cannot do that or the tool is not seen.
/// Throws what PlanarRobot::move_to() throws.
std::optional<Eigen::Vector3d> measure_play(PlanarRobot& robot, const JointPlanner& planner,
                                            const ServoSettings& settings, TipSensor& sensor,
                                            Clock& clock);

}  // namespace planar
