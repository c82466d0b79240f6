#include "planar_servo/servo/path/gear_play.h"

#include <fmt/format.h>

#include <Eigen/LU>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// A motor commanded back by less than this has not reversed: the corrections by vision tremble by
/// that much. 0.01 mm at an arm's length of 0.3 m.
constexpr double kTremble_rad = 3e-5;

ServoSettings approaching(ServoSettings settings, Approach approach) {
  settings.approach = approach;
  return settings;
}

/// Returns how far motors 1 and 2 fell short from above, by where the end point was seen each time.
PlayProbe play_between(const JointPlanner& planner, const Joints& here, double margin_rad,
                       const TipMeasurement& from_above, const TipMeasurement& from_below) {
  for (const TipMeasurement& look : {from_above, from_below})
    if (!look.ok()) return {std::nullopt, "the tool was not measured: " + look.word};
  const Eigen::Matrix2d joints_per_motor =
      planner.transmission().coupling_matrix().inverse().topLeftCorner<2, 2>();
  const Eigen::Matrix2d J = planner.arm().jacobian(here) * joints_per_motor;
  const Eigen::Vector2d play = J.inverse() * (from_above.tip.p - from_below.tip.p);
  if (!(play.cwiseAbs().maxCoeff() <= margin_rad))
    return {std::nullopt,
            fmt::format("the looks differ by {:.3f} and {:.3f} deg of motors 1 and 2, but play "
                        "cannot show more than the approach margin of {:.3f} deg",
                        play.x() / kDegree, play.y() / kDegree, margin_rad / kDegree)};
  return {Eigen::Vector3d(play[0], play[1], 0.0).cwiseMax(0.0).eval()};
}

}  // namespace

GearPlay::GearPlay(const Transmission& transmission, const Eigen::Vector3d& play_rad,
                   const Joints& theta)
    : transmission_(transmission),
      play_(play_rad),
      held_(transmission.motors_from_joints(theta)),
      extreme_(held_) {}

Joints GearPlay::behind(const Joints& drives) {
  const Eigen::Vector3d motors = transmission_.motors_from_joints(drives);
  held_ = held_.cwiseMax(motors).cwiseMin(motors + play_);
  return transmission_.joints_from_motors(held_);
}

Joints GearPlay::command(const Joints& wanted) {
  Eigen::Vector3d motors = transmission_.motors_from_joints(wanted);
  for (int i = 0; i < 3; ++i) {
    const double ahead = side_[i] * (motors[i] - extreme_[i]);
    if (ahead < -kTremble_rad) side_[i] = -side_[i];
    if (ahead > 0.0 || ahead < -kTremble_rad) extreme_[i] = motors[i];
    if (side_[i] < 0.0) motors[i] -= play_[i];
  }
  return transmission_.joints_from_motors(motors);
}

PlayProbe measure_play(PlanarRobot& robot, const JointPlanner& planner,
                       const ServoSettings& settings, TipSensor& sensor, Clock& clock) {
  const Transmission& transmission = planner.transmission();
  const Joints here = robot.commanded_joints();
  const Joints above =
      transmission.joints_from_motors(transmission.motors_from_joints(here) +
                                      Eigen::Vector3d::Constant(settings.approach_margin_rad));
  const ServoSettings straight = approaching(settings, Approach::kDirect);
  const ServoSettings from_below = approaching(settings, Approach::kOneSide);
  for (const auto& refusal : {approach_refusal(planner, straight, here, above),
                              approach_refusal(planner, straight, above, here),
                              approach_refusal(planner, from_below, here, here)})
    if (refusal) return {std::nullopt, *refusal};
  const auto go = [&](const ServoSettings& how, const Joints& theta) {
    return arrive(robot, planner, how, theta, [&] { return sensor.fault(); });
  };
  const auto look = [&] {
    clock.sleep_for_s(settings.settle_s);
    return sensor.measure(planner.arm().forward(here), settings.frames_per_measurement);
  };
  auto obstacle = go(straight, above);
  if (!obstacle) obstacle = go(straight, here);
  if (obstacle) return {std::nullopt, obstacle->reason, obstacle};
  const TipMeasurement down = look();
  if ((obstacle = go(from_below, here))) return {std::nullopt, obstacle->reason, obstacle};
  return play_between(planner, here, settings.approach_margin_rad, down, look());
}

}  // namespace planar
