#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/cell/servo_settings.h"

namespace planar {

/// Returns where the arm rests one after the other in order to arrive at these joint angles: there
/// alone, or first short of them by the settings' approach margin in every motor.
std::vector<Joints> approach_stops(const Transmission& transmission, const ServoSettings& settings,
                                   const Joints& theta);

/// Returns why the arm must not arrive at `theta` from where it rests: what forbids the end, a stop
/// before it, or the way there; empty when nothing does.
std::optional<std::string> approach_refusal(const JointPlanner& planner,
                                            const ServoSettings& settings, const Joints& from,
                                            const Joints& theta);

/// Returns by how much play may move the end point when motors arrive from either side, metres:
/// what the settings' approach margin, which exceeds the play, comes to at full reach.
double play_allowance_m(const PlanarArm& arm, const ServoSettings& settings);

}  // namespace planar
