#include "planar_servo/servo/arrival.h"

namespace planar {

std::optional<Obstacle> arrive(PlanarRobot& robot, const JointPlanner& planner,
                               const ServoSettings& settings, const Joints& theta,
                               const PlanarRobot::Guard& guard) {
  const auto move = [&](const Joints& to) -> std::optional<Obstacle> {
    if (const auto objection = robot.move_to(to, guard)) return Obstacle{false, *objection};
    return std::nullopt;
  };
  if (const auto refusal = planner.refusal(theta)) return Obstacle{true, *refusal};
  if (settings.approach == Approach::kDirect) return move(theta);
  const Transmission& transmission = planner.transmission();
  const Eigen::Vector3d motors = transmission.motors_from_joints(theta);
  const Joints short_of = transmission.joints_from_motors(
      motors - Eigen::Vector3d::Constant(settings.approach_margin_rad));
  if (const auto violation = transmission.limit_violation(short_of))
    return Obstacle{true, "on the approach from one side, " + *violation};
  if (const auto obstacle = move(short_of)) return obstacle;
  return move(theta);
}

}  // namespace planar
