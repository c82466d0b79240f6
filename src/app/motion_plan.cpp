#include "app/motion_plan.h"

#include <fmt/format.h>

#include "core/error.h"

namespace planar {
namespace {

class JointPlanner {
 public:
  explicit JointPlanner(const CellSettings& cell)
      : cell_(cell),
        arm_(cell.arm.geometry),
        transmission_(cell.transmission),
        near_(cell.arm.home) {}

  Joints joints_of(const PlanRow& row, Faults& faults) {
    if (is_board_view(row)) return cell_.arm.home;
    const auto refuse = [&](const std::string& why) {
      faults.add(fmt::format("plan row '{}': {}", row.id, why));
      return near_;
    };
    Joints theta = cell_.arm.home;
    if (const auto* joints = std::get_if<Joints>(&row.where)) {
      theta = *joints;
    } else {
      const InverseResult inverse =
          arm_.inverse(std::get<TipPose>(row.where), cell_.arm.elbow, near_);
      if (inverse.status != ReachStatus::kOk) return refuse(describe(inverse.status));
      theta = transmission_.branch_within_limits(inverse.theta, near_).value_or(inverse.theta);
    }
    if (const auto why = transmission_.limit_violation(theta)) return refuse(*why);
    if (const auto why = cell_.workspace.violation(arm_.forward(theta).p)) return refuse(*why);
    near_ = theta;
    return theta;
  }

 private:
  const CellSettings& cell_;
  PlanarArm arm_;
  Transmission transmission_;
  Joints near_;
};

}  // namespace

bool is_board_view(const PlanRow& row) {
  return row.plan == "grid" || row.plan == "plane_grid";
}

std::vector<Joints> joints_of_plan(const CellSettings& cell, const std::vector<PlanRow>& plan) {
  JointPlanner planner(cell);
  Faults faults;
  std::vector<Joints> joints;
  for (const PlanRow& row : plan) joints.push_back(planner.joints_of(row, faults));
  faults.throw_if_any();
  return joints;
}

}  // namespace planar
