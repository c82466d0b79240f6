#include "planar_servo/core/plan.h"

#include "planar_servo/core/names.h"

namespace planar {
namespace {

constexpr Named<Plan> kPlans[] = {{Plan::kHeldBoard, "grid"},  {Plan::kLaidBoard, "plane_grid"},
                                  {Plan::kTrain, "train"},     {Plan::kTest, "test"},
                                  {Plan::kSweep1, "sweep1"},   {Plan::kSweep3, "sweep3"},
                                  {Plan::kControl, "control"}, {Plan::kCheck, "check"}};

}  // namespace

const char* name(Plan plan) {
  return name_in(kPlans, plan);
}

std::optional<Plan> plan_named(std::string_view name) {
  return value_named(kPlans, name);
}

std::vector<Plan> all_plans() {
  std::vector<Plan> plans;
  for (const Named<Plan>& entry : kPlans) plans.push_back(entry.value);
  return plans;
}

std::vector<std::string> plan_names() {
  return names_of(kPlans);
}

bool shows_board(Plan plan) {
  return plan == Plan::kHeldBoard || plan == Plan::kLaidBoard;
}

}  // namespace planar
