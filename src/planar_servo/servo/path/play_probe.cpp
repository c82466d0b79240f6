#include "planar_servo/servo/path/play_probe.h"

#include <Eigen/LU>

#include "planar_servo/servo/arrival.h"

namespace planar {

std::optional<Eigen::Vector3d> measure_play(PlanarRobot& robot, const JointPlanner& planner,
                                            const ServoSettings& settings, TipSensor& sensor,
                                            Clock& clock) {
  const Transmission& transmission = planner.transmission();
  const Joints here = robot.commanded_joints();
  const Joints above =
      transmission.joints_from_motors(transmission.motors_from_joints(here) +
                                      Eigen::Vector3d::Constant(settings.approach_margin_rad));
  ServoSettings from_above = settings, from_below = settings;
  from_above.approach = Approach::kDirect;
  from_below.approach = Approach::kOneSide;
  const auto go = [&](const ServoSettings& how, const Joints& theta) {
    return !arrive(robot, planner, how, theta, [&] { return sensor.fault(); });
  };
  const auto look = [&] {
    clock.sleep_for_s(settings.settle_s);
    return sensor.measure(planner.arm().forward(here), settings.frames_per_measurement);
  };
  if (!go(from_above, above) || !go(from_above, here)) return std::nullopt;
  const TipMeasurement down = look();
  if (!go(from_below, here)) return std::nullopt;
  const TipMeasurement up = look();
  if (!down.ok() || !up.ok()) return std::nullopt;
  const Eigen::Matrix2d joints_per_motor =
      transmission.coupling_matrix().inverse().topLeftCorner<2, 2>();
  const Eigen::Matrix2d J = planner.arm().jacobian(here) * joints_per_motor;
  const Eigen::Vector2d play = J.inverse() * (down.tip.p - up.tip.p);
  return Eigen::Vector3d(play[0], play[1], 0.0).cwiseMax(0.0).eval();
}

}  // namespace planar
