#pragma once

#include <cmath>

#include "planar_servo/base/core/units.h"
#include "planar_servo/loop/servo/position_servo.h"
#include "support/simulated_cell.h"

namespace planar::test {

struct MachineKind {
  Rotation rotation{Rotation::kCounterclockwise};
  Elbow elbow{Elbow::kLeft};
  Coupling coupling{Coupling::kRelative};
  double gear_ratio{100.0};
  double play_rad{0.0};
  bool as_its_data_sheet{false};
  double scatter_m{0.0};
};

inline TransmissionSettings transmission_settings(const MachineKind& kind) {
  TransmissionSettings settings;
  settings.coupling = {kind.coupling, Coupling::kRelative};
  settings.drives[0] = {10000.0, kind.gear_ratio, 1, 1.0, 5.0};
  settings.drives[1] = {10000.0, kind.gear_ratio, -1, 1.0, 5.0};
  settings.drives[2] = {10000.0, 50.0, 1, 2.0, 10.0};
  settings.limits_rad.fill({-6.0, 6.0});
  return settings;
}

inline SimulatedCell::Truth truth_of(const MachineKind& kind) {
  SimulatedCell::Truth truth;
  truth.sense = kind.rotation == Rotation::kCounterclockwise ? 1.0 : -1.0;
  truth.relative = kind.coupling == Coupling::kRelative;
  truth.pulses_per_rad = Eigen::Vector3d(kind.gear_ratio, -kind.gear_ratio, 50.0) * 1e4 / (2 * kPi);
  truth.play_rad = kind.play_rad;
  truth.scatter_m = kind.scatter_m;
  if (kind.as_its_data_sheet) {
    truth.link1_m = truth.link2_m = 0.3;
    truth.zero1_rad = truth.zero2_rad = truth.zero3_rad = 0.0;
  }
  return truth;
}

/// A servo that believes its data sheet, on a machine that does not keep it.
struct ServoBench {
  explicit ServoBench(const MachineKind& kind = {})
      : cell(truth_of(kind)),
        sensor(cell),
        planner(PlanarArm({{0.3, 0.3}, kind.rotation}), Transmission(transmission_settings(kind)),
                {0.06, 0.54, {}}, kind.elbow),
        robot(planner.arm(), planner.transmission(), cell.drives(), cell.clock()) {
    robot.energize();
    settings.approach = Approach::kDirect;
  }

  ServoResult move_to(const TipPose& target) {
    return PositionServo(settings, limits, planner, robot, sensor, cell.clock()).move_to(target);
  }
  double true_distance(const TipPose& target) const {
    return (cell.true_tip().p - target.p).norm();
  }

  SimulatedCell cell;
  SimulatedSensor sensor;
  JointPlanner planner;
  PlanarRobot robot;
  ServoSettings settings;
  GuardLimits limits;
};

inline TipPose on_circle(int i) {
  const double direction = 2.0 * kPi * i / 12;
  return {{-0.2 + 0.15 * std::cos(direction), 0.2 + 0.15 * std::sin(direction)}, 0.3};
}

inline const TipPose kTarget{{-0.15, 0.32}, 0.3};

}  // namespace planar::test
