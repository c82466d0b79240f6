#include "planar_servo/work/homing/posture_candidates.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/loop/servo/motion_guard.h"

namespace planar {

std::vector<PostureCandidate> posture_candidates(const CalibratedCell& cell,
                                                 const LampPlaces& lamps_B) {
  const ArmSettings& arm = cell.settings.arm;
  std::vector<PostureCandidate> candidates;
  for (const bool exchanged : {false, true}) {
    const TipPose tip = tip_from_places({lamps_B[exchanged ? 1 : 0], lamps_B[exchanged ? 0 : 1]},
                                        cell.vision->tool);
    CellSettings further = cell.settings;
    double& border_m = further.workspace.radius_max_m;
    border_m =
        std::max(border_m, tip.p.norm()) + play_allowance_m(cell.planner.arm(), further.servo);
    for (const Elbow elbow :
         {arm.elbow, arm.elbow == Elbow::kLeft ? Elbow::kRight : Elbow::kLeft}) {
      const InverseResult inverse = cell.planner.arm().inverse(tip, elbow, arm.home);
      if (inverse.status != ReachStatus::kOk) continue;
      if (const auto theta = cell.planner.transmission().branch_within_limits(
              inverse.theta, arm.home, {-kBeyondLimits, -kBeyondLimits}))
        candidates.push_back({*theta, elbow, exchanged, joint_planner(further)});
    }
  }
  return candidates;
}

Joints turned(const Transmission& transmission, const Joints& theta, int motor, double turn) {
  return transmission.joints_from_motors(transmission.motors_from_joints(theta) +
                                         turn * Eigen::Vector3d::Unit(motor));
}

bool may_turn(const JointPlanner& planner, const Joints& theta, int motor, double turn) {
  const Transmission& transmission = planner.transmission();
  const Joints end = turned(transmission, theta, motor, turn);
  if (transmission.limit_violation(end) || planner.way_refusal(theta, end)) return false;
  const Eigen::Vector2d limits =
      transmission.settings().limits_rad[static_cast<std::size_t>(motor)];
  const double angle = transmission.motors_from_joints(theta)[motor];
  const auto room = [](double gap) { return gap - 2.0 * kPi * std::floor(gap / (2.0 * kPi)); };
  return turn <= room(limits[1] - angle) && -turn <= room(angle - limits[0]);
}

std::vector<double> test_turns(const JointPlanner& planner,
                               const std::vector<PostureCandidate>& postures, int motor,
                               double take_up, double turn) {
  const Joints& first = postures.front().theta;
  const auto radius_m = [&](const Joints& theta) { return planner.arm().forward(theta).p.norm(); };
  const Joints end = turned(planner.transmission(), first, motor, turn);
  const double inward = radius_m(end) > radius_m(first) + JointPlanner::kWayResolution_m ? -1 : 1;
  std::vector<double> turns;
  for (const bool further_out : {false, true})
    for (const double share : {1.0, 0.5, 0.25})
      for (const double sense : {inward, -inward})
        if (std::all_of(postures.begin(), postures.end(), [&](const PostureCandidate& posture) {
              return may_turn(further_out ? posture.planner : planner, posture.theta, motor,
                              sense * (take_up + share * turn));
            }))
          turns.push_back(sense * share * turn);
  return turns;
}

}  // namespace planar
