#include "planar_servo/core/plan.h"

namespace planar {

const char* name(Plan plan) {
  return name_in(kPlans, plan);
}

bool shows_board(Plan plan) {
  return plan == Plan::kHeldBoard || plan == Plan::kLaidBoard;
}

bool needs_reading(Plan plan) {
  return !shows_board(plan) && plan != Plan::kPose;
}

}  // namespace planar
