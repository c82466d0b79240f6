#include "planar_servo/files/tables/plans.h"

#include <fmt/format.h>

#include <algorithm>

namespace planar {

const std::vector<std::string>& plan_names() {
  static const std::vector<std::string> names{kHeldBoardPlan, kLaidBoardPlan, "train",   "test",
                                              "sweep1",       "sweep3",       "control", "check"};
  return names;
}

bool shows_board(const std::string& plan) {
  return plan == kHeldBoardPlan || plan == kLaidBoardPlan;
}

void list_plan(Columns& columns, std::string& plan) {
  columns.text("plan", plan);
  if (!columns.reading()) return;
  const auto& names = plan_names();
  if (std::find(names.begin(), names.end(), plan) == names.end())
    columns.check(false, fmt::format("plan is '{}'; allowed are {}", plan, fmt::join(names, ", ")));
}

}  // namespace planar
