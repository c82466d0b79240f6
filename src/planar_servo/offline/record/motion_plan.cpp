#include "planar_servo/offline/record/motion_plan.h"

#include <fmt/format.h>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

JointPlan plan_row(const JointPlanner& planner, const PlanRow& row, const Joints& home,
                   const Joints& near) {
  if (shows_board(row.plan)) return {home, {}};
  JointPlan plan;
  if (const auto* theta = std::get_if<Joints>(&row.where))
    plan = {*theta, planner.refusal(*theta)};
  else
    plan = planner.plan(std::get<TipPose>(row.where), near);
  if (!plan.refusal) plan.refusal = planner.way_refusal(near, plan.theta);
  return plan;
}

}  // namespace

std::vector<Joints> joints_of_plan(const CellSettings& cell, const std::vector<PlanRow>& plan) {
  const JointPlanner planner = joint_planner(cell);
  Faults faults;
  std::vector<Joints> joints;
  Joints near = cell.arm.home;
  for (const PlanRow& row : plan) {
    const JointPlan found = plan_row(planner, row, cell.arm.home, near);
    if (found.refusal) {
      faults.add(fmt::format("plan row '{}': {}", row.id, *found.refusal));
    } else if (!shows_board(row.plan)) {
      near = found.theta;
    }
    joints.push_back(found.theta);
  }
  faults.throw_if_any();
  return joints;
}

}  // namespace planar
