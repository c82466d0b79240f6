#include "planar_servo/hardware/robot/homing.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

void ask(const MayHome& may_home, Homing way, const std::string& unhomed,
         const std::string& remedy) {
  if (!may_home || !may_home(way, unhomed)) throw DriveError({unhomed, remedy, "", Cause::kDevice});
}

void search_home(PlanarRobot& robot, int joint) {
  const SteadyClock clock;
  const double begun_s = clock.now_s();
  spdlog::info(fmt::format("homing: drive {} searches its home switch, for {:.0f} s at most",
                           joint + 1, PlanarRobot::kHomingTimeout_s));
  robot.search_home(joint);
  spdlog::info(
      fmt::format("homing: drive {} is home after {:.1f} s", joint + 1, clock.now_s() - begun_s));
}

}  // namespace

void home_where_needed(PlanarRobot& robot, const MayHome& may_home, const std::string& beside,
                       const std::function<void()>& by_sight) {
  if (robot.homes_by_sight() && !robot.unhomed().empty()) {
    if (!by_sight)
      throw DriveError(Refusal{"drives that have lost their position are homed by sight",
                               "calibrate the cell first; until then turn them to marks and name "
                               "these under home (reference: taught)",
                               "", Cause::kDevice});
    ask(may_home, Homing::kSearch,
        "drives that have lost their position: the camera finds where they stand, for which they "
        "turn a little",
        "start with --home, which moves the arm" + beside);
    return by_sight();
  }
  std::vector<int> to_search, at_mark;
  std::string with_switch = "drives that have lost their position:";
  std::string with_mark = "drives that have lost their position and have no home switch:";
  for (const int joint : robot.unhomed()) {
    const auto mark = robot.home_mark(joint);
    (mark ? at_mark : to_search).push_back(joint);
    if (mark)
      with_mark += fmt::format(" {} (mark at {:.3f} deg)", joint + 1, *mark / kDegree);
    else
      with_switch += fmt::format(" {}", joint + 1);
  }
  if (!at_mark.empty())
    ask(may_home, Homing::kMark, with_mark,
        "turn them to their marks, then start with --at-marks" + beside);
  // Not by planar-jog: a board with Grbl has lost its position again when the next program opens
  // it.
  if (!to_search.empty())
    ask(may_home, Homing::kSearch, with_switch,
        "start with --home, which searches their home switches and moves the arm" + beside);
  for (const int joint : at_mark) robot.teach_home(joint);
  for (const int joint : to_search) search_home(robot, joint);
}

}  // namespace planar
