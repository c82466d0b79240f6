#pragma once

#include <optional>
#include <string>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/servo/path/path.h"

namespace planar {

/// Holds what a path asks of the motors, or why it must not be followed.
struct PathDemand {
  std::optional<std::string> refusal;  ///< in words, with the place on the path
  Joints start{0.0, 0.0, 0.0};         ///< joints at the path's beginning
  /// The greatest share of its speed that a motor needs, and which motor that is.
  double speed_share{0.0};
  int fastest_motor{0};  ///< counts from 0
};

/// Follows the path without moving, in steps of kPathStep_s, from joints near to `near`. It refuses
/// what the planner refuses, and motors that would have to be faster, or to speed up faster, than
/// their drives do; a tenth of both is kept for the corrections.
PathDemand path_demand(const JointPlanner& planner, const Path& path, const PathTiming& timing,
                       const Joints& near);

/// The time from one command to the next, seconds.
constexpr double kPathStep_s = 0.02;

}  // namespace planar
