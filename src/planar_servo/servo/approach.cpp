#include "planar_servo/servo/approach.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace planar {

std::vector<Joints> approach_stops(const Transmission& transmission, const ServoSettings& settings,
                                   const Joints& theta) {
  if (settings.approach == Approach::kDirect) return {theta};
  const Eigen::Vector3d motors = transmission.motors_from_joints(theta);
  return {transmission.joints_from_motors(motors -
                                          Eigen::Vector3d::Constant(settings.approach_margin_rad)),
          theta};
}

std::optional<std::string> approach_refusal(const JointPlanner& planner,
                                            const ServoSettings& settings, const Joints& from,
                                            const Joints& theta) {
  if (auto refusal = planner.refusal(theta)) return refusal;
  Joints rest = from;
  for (const Joints& stop : approach_stops(planner.transmission(), settings, theta)) {
    auto refusal = planner.transmission().limit_violation(stop);
    if (!refusal) refusal = planner.way_refusal(rest, stop);
    if (refusal && stop != theta) return "on the approach from one side, " + *refusal;
    if (refusal) return refusal;
    rest = stop;
  }
  return std::nullopt;
}

double play_allowance_m(const PlanarArm& arm, const ServoSettings& settings) {
  return settings.approach_margin_rad * arm.geometry().link_lengths_m.sum();
}

std::optional<Obstacle> arrive(PlanarRobot& robot, const JointPlanner& planner,
                               const ServoSettings& settings, const Joints& theta,
                               const PlanarRobot::Guard& guard) {
  if (const auto refusal = approach_refusal(planner, settings, robot.commanded_joints(), theta))
    return Obstacle{true, *refusal};
  for (const Joints& stop : approach_stops(planner.transmission(), settings, theta))
    if (const auto objection = robot.move_to(stop, guard)) return Obstacle{false, *objection};
  return std::nullopt;
}

bool wait_for_camera(const FrameSource& camera, const PlanarRobot& robot, Clock& clock,
                     const std::string& id, const std::string& reason, double deadline_s) {
  constexpr double kPoll_s = 0.05;
  const double lost_s = clock.now_s();
  spdlog::warn(fmt::format("{}: {}; the arm stands and waits", id, reason));
  while (camera.fault()) {
    if (clock.now_s() > deadline_s) return false;
    robot.throw_if_stopped();
    clock.sleep_for_s(kPoll_s);
  }
  if (clock.now_s() > deadline_s) return false;
  spdlog::info(fmt::format("{}: the camera delivers again after {:.1f} s; resuming", id,
                           clock.now_s() - lost_s));
  return true;
}

}  // namespace planar
