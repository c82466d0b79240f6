#include "planar_servo/arm/joint_planner.h"

namespace planar {

JointPlanner::JointPlanner(const PlanarArm& arm, const Transmission& transmission,
                           const Workspace& workspace, Elbow elbow)
    : arm_(arm), transmission_(transmission), workspace_(workspace), elbow_(elbow) {}

std::optional<std::string> JointPlanner::refusal(const Joints& theta) const {
  if (auto outside = workspace_.violation(arm_.forward(theta).p)) return outside;
  return transmission_.limit_violation(theta);
}

JointPlan JointPlanner::plan(const TipPose& target, const Joints& near) const {
  const InverseResult inverse = arm_.inverse(target, elbow_, near);
  if (inverse.status != ReachStatus::kOk) return {{}, describe(inverse.status)};
  const Joints theta =
      transmission_.branch_within_limits(inverse.theta, near).value_or(inverse.theta);
  return {theta, refusal(theta)};
}

}  // namespace planar
