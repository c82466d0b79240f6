#include "planar_servo/robot/homing.h"

#include <fmt/format.h>

namespace planar {

void home_where_needed(PlanarRobot& robot, const MayHome& may_home, const std::string& remedy) {
  const std::vector<int> unhomed = robot.unhomed();
  if (unhomed.empty()) return;
  std::string text = "drives that have lost their position:";
  for (const int joint : unhomed) text += fmt::format(" {}", joint + 1);
  if (!may_home || !may_home(text)) throw DriveError(text + "; " + remedy);
  for (const int joint : unhomed) robot.search_home(joint);
}

}  // namespace planar
