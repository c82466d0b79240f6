#pragma once

#include <functional>
#include <string>

#include "planar_servo/robot/planar_robot.h"

namespace planar {

/// Is asked whether drives that lost their position may be homed now, which moves the arm. Its text
/// says which.
using MayHome = std::function<bool(const std::string& unhomed)>;

/// Searches the home switches of the drives that have lost their position, if that is allowed; an
/// empty `may_home` forbids it. Throws DriveError with the remedy when it is not, and as
/// PlanarRobot::search_home() does.
void home_where_needed(PlanarRobot& robot, const MayHome& may_home, const std::string& remedy);

}  // namespace planar
