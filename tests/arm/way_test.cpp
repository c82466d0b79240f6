#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/arm/joint_planner.h"
#include "planar_servo/virtual_cell/virtual_drive.h"

namespace planar {
namespace {

const ArmGeometry kGeometry{{0.3, 0.25}, Rotation::kCounterclockwise};

/// Returns motors of different speeds, so that no way is straight, not even in joints.
Transmission transmission_with(Coupling coupling) {
  TransmissionSettings settings;
  settings.coupling = {coupling, coupling};
  settings.drives[0] = {10000.0, 100.0, 1, 1.0, 5.0};
  settings.drives[1] = {10000.0, 100.0, -1, 1.7, 3.0};
  settings.drives[2] = {10000.0, 50.0, 1, 2.0, 10.0};
  for (auto& limits : settings.limits_rad) limits = {-20.0, 20.0};
  return Transmission(settings);
}

/// Returns how much deeper than at its beginning the way leads beyond any border, by the virtual
/// drive's motion in steps of half a millisecond.
double sampled_depth_m(const Transmission& transmission, const Workspace& workspace,
                       const Joints& from, const Joints& to) {
  const PlanarArm arm(kGeometry);
  const Eigen::Vector3d start = transmission.motors_from_joints(from);
  const Eigen::Vector3d end = transmission.motors_from_joints(to);
  std::vector<MotionProfile> motors;
  double end_s = 0.0;
  for (int i = 0; i < 3; ++i) {
    const MotorDrive& drive = transmission.settings().drives[static_cast<std::size_t>(i)];
    motors.emplace_back(0.0, MotionState{start[i], 0.0}, end[i],
                        MotionLimits{drive.max_speed_rad_s, drive.max_acceleration_rad_s2});
    end_s = std::max(end_s, motors.back().end_s());
  }
  double deepest = -1.0;
  for (const Border& border : workspace.borders()) {
    const double allowed = std::max(0.0, border.depth_m(arm.forward(from).p));
    for (double t_s = 0.0; t_s <= end_s + 5e-4; t_s += 5e-4) {
      const Eigen::Vector3d turned(motors[0].state_at(t_s).position,
                                   motors[1].state_at(t_s).position,
                                   motors[2].state_at(t_s).position);
      const Eigen::Vector2d p = arm.forward(transmission.joints_from_motors(turned)).p;
      deepest = std::max(deepest, border.depth_m(p) - allowed);
    }
  }
  return deepest;
}

}  // namespace

TEST_CASE("A way is refused just where the virtual drives would cross a border, never missed") {
  constexpr double kSampling = 1e-6;  // at most 1 m/s^2 about the deepest place, sampled in 0.5 ms
  const Workspace workspace{0.1, 0.5, {{{0.25, 0.2}, 0.06}, {{-0.3, 0.0}, 0.03}}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  int crossing = 0, clear = 0;
  for (const Coupling coupling : {Coupling::kRelative, Coupling::kAbsolute}) {
    const Transmission transmission = transmission_with(coupling);
    const JointPlanner planner(PlanarArm(kGeometry), transmission, workspace, Elbow::kLeft);
    for (int i = 0; i < 300; ++i) {
      const Joints from{angle(random), angle(random), angle(random)};
      const Joints to = from + 0.5 * Joints{angle(random), angle(random), angle(random)};
      const double depth = sampled_depth_m(transmission, workspace, from, to);
      const auto refusal = planner.way_refusal(from, to);
      CAPTURE(depth, refusal.value_or("no refusal"));
      if (depth > JointPlanner::kWayResolution_m + kSampling) CHECK(refusal);
      if (depth < -kSampling) CHECK_FALSE(refusal);
      ++(refusal ? crossing : clear);
    }
  }
  CHECK(crossing > 100);
  CHECK(clear > 50);
}

TEST_CASE("A small disc far along a turn of joint 1 alone is not missed") {
  const Joints stretched(-0.5, -0.5, 0.0);
  for (const double direction : {-0.45, 0.45}) {
    const PlanarArm arm(kGeometry);
    const Eigen::Vector2d p = arm.forward({direction, direction, 0.0}).p;
    const JointPlanner planner(arm, transmission_with(Coupling::kRelative),
                               {0.0, 1.0, {{p, 0.001}}}, Elbow::kLeft);
    CHECK(planner.way_refusal(stretched, {0.5, 0.5, 0.0}));
  }
}

TEST_CASE("A refused way names the disc and how deep it leads, and an arm inside may leave") {
  const Transmission transmission = transmission_with(Coupling::kRelative);
  const PlanarArm arm(kGeometry);
  const Joints from(0.0, 1.5, 0.0), to(1.0, 2.5, 0.0), middle(0.5, 2.0, 0.0);
  const Eigen::Vector2d p = arm.forward(middle).p;
  // A turn about the base at one radius: the way goes through the disc's centre.
  const JointPlanner planner(arm, transmission, {0.1, 0.5, {{p, 0.05}}}, Elbow::kLeft);
  CHECK_FALSE(planner.refusal(from));
  CHECK_FALSE(planner.refusal(to));
  CHECK_THAT(*planner.way_refusal(from, to),
             Catch::Contains("50.000 mm into the keep-out disc of 50.000 mm about (") &&
                 Catch::Contains("targets in between"));
  CHECK_FALSE(planner.way_refusal(middle, to));
  CHECK(planner.way_refusal(from, middle));
  const JointPlanner ring(arm, transmission, {0.1, 0.4, {}}, Elbow::kLeft);
  CHECK_THAT(*ring.way_refusal({0.0, 1.6, 0.0}, {0.0, 0.5, 0.0}),
             Catch::Contains("beyond the outer border of the workspace of 400.000 mm"));
}

}  // namespace planar
