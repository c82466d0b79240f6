#include "planar_servo/servo/arrival.h"

#include "planar_servo/servo/approach.h"

namespace planar {

std::optional<Obstacle> arrive(PlanarRobot& robot, const JointPlanner& planner,
                               const ServoSettings& settings, const Joints& theta,
                               const PlanarRobot::Guard& guard) {
  if (const auto refusal = approach_refusal(planner, settings, robot.commanded_joints(), theta))
    return Obstacle{true, *refusal};
  for (const Joints& stop : approach_stops(planner.transmission(), settings, theta))
    if (const auto objection = robot.move_to(stop, guard)) return Obstacle{false, *objection};
  return std::nullopt;
}

}  // namespace planar
