#pragma once

#include <functional>
#include <string>

#include "planar_servo/hardware/robot/planar_robot.h"

namespace planar {

/// How a drive that does not know its position comes to know it.
enum class Homing {
  kSearch,  ///< it searches its home switch, which moves the arm
  kMark,    ///< it has no switch and stands at its mark already
  kTurn,    ///< it stands on the turn nearest to home, of several that the camera cannot tell apart
};

/// Is asked whether the drives that a text names may be homed in this way now.
using MayHome = std::function<bool(Homing way, const std::string& unhomed)>;

/// Homes the drives that have lost their position, if that is allowed; an empty `may_home` forbids
/// it. All is asked before the first drive moves. Throws DriveError when it is not allowed, with
/// the option to start with, followed by `beside`, and as PlanarRobot::search_home() does. An arm
/// that homes by sight is homed by `by_sight`; without it, it throws DriveError.
void home_where_needed(PlanarRobot& robot, const MayHome& may_home, const std::string& beside = "",
                       const std::function<void()>& by_sight = {});

}  // namespace planar
