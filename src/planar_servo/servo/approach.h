#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/cell/servo_settings.h"
#include "planar_servo/core/clock.h"
#include "planar_servo/devices/frame_source.h"
#include "planar_servo/robot/planar_robot.h"

namespace planar {

/// Returns the stops, in order, of an arm that arrives at these joint angles: there alone, or first
/// short of them by the settings' approach margin in every motor.
std::vector<Joints> approach_stops(const Transmission& transmission, const ServoSettings& settings,
                                   const Joints& theta);

/// Returns why the arm must not arrive at `theta` from where it rests: what forbids the end, a stop
/// before it, or the way there; empty when nothing does.
std::optional<std::string> approach_refusal(const JointPlanner& planner,
                                            const ServoSettings& settings, const Joints& from,
                                            const Joints& theta);

/// Returns by how much play may move the end point when motors arrive from either side, metres: the
/// settings' approach margin, which exceeds the play, at full reach.
double play_allowance_m(const PlanarArm& arm, const ServoSettings& settings);

/// Says what kept the arm from arriving.
struct Obstacle {
  bool refused{false};  ///< the move is forbidden; else the guard stopped the arm on the way
  std::string reason;
};

/// Moves the arm to these joints as the settings say: straight, or with every motor from the same
/// side. Nothing moves when the planner refuses the joints, the place short of them or the way
/// there. Throws what PlanarRobot::move_to() throws.
std::optional<Obstacle> arrive(PlanarRobot& robot, const JointPlanner& planner,
                               const ServoSettings& settings, const Joints& theta,
                               const PlanarRobot::Guard& guard);

/// The longest wait for a camera that fails.
constexpr double kCameraPatience_s = 60.0;

/// Waits, with the arm at rest, until the camera delivers properly again, and logs it. `id` names
/// what is to be continued, `reason` what is wrong. Returns false once the clock is past
/// `deadline_s`. Throws what PlanarRobot::throw_if_stopped() throws.
bool wait_for_camera(const FrameSource& camera, const PlanarRobot& robot, Clock& clock,
                     const std::string& id, const std::string& reason, double deadline_s);

}  // namespace planar
