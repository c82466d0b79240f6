#include "planar_servo/work/run/check_ways.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/units.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/geometry/tool/vision_tip.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/work/run/cell_check.h"

namespace planar {
namespace {

/// Places that are tried for the first moves when the arm must not make them where it stands.
constexpr int kRingPlaces = 24;
constexpr char kCheck[] = "the check of the cell";
constexpr char kWayOn[] =
    "correct `arm` and `workspace` in the cell file, keep other places by planar-pair-tracker "
    "--health-out, or move without the check (--no-health)";

}  // namespace

Eigen::Vector3d CheckWays::first_moves() {
  return kDegree * Eigen::Vector3d(40.0, 40.0, 60.0);
}

CheckWays::CheckWays(const CellSettings& cell, Views views)
    : cell_(cell), views_(std::move(views)), planner_(joint_planner(cell)) {}

bool CheckWays::allows(const Joints& from, const Joints& theta) const {
  return !approach_refusal(planner_, cell_.servo, from, theta) &&
         views_(planner_.arm().forward(theta));
}

std::optional<Joints> CheckWays::start(const Joints& present) const {
  if (allows(present, present)) return present;
  const double radius_m = 0.5 * (cell_.workspace.radius_min_m + cell_.workspace.radius_max_m);
  const Eigen::Vector2d p = planner_.arm().forward(present).p;
  const double direction = std::atan2(p.y(), p.x());
  for (int i = 0; i < kRingPlaces; ++i) {
    const int steps = (i + 1) / 2;
    const double turn = (i % 2 == 0 ? steps : -steps) * 2.0 * kPi / kRingPlaces;
    const JointPlan plan = planner_.plan(
        {radius_m * rotation2d(direction + turn).col(0), cell_.tool_orientation}, present);
    if (!plan.refusal && allows(present, plan.theta)) return plan.theta;
  }
  return std::nullopt;
}

Joints CheckWays::with_motor_turned(const Joints& theta, int motor) const {
  const Transmission& transmission = planner_.transmission();
  for (const double share : {1.0, -1.0, 0.5, -0.5}) {
    Eigen::Vector3d motors = transmission.motors_from_joints(theta);
    motors[motor] += share * first_moves()[motor];
    Joints turned = transmission.joints_from_motors(motors);
    if (allows(theta, turned)) return turned;
  }
  return theta;
}

VisitPlan CheckWays::visits(Joints theta, const std::vector<HealthPlace>& places) const {
  const Transmission& transmission = planner_.transmission();
  VisitPlan plan;
  std::vector<std::size_t> left(places.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  const auto bar = [&](std::size_t i) {
    return approach_refusal(planner_, cell_.servo, theta, places[i].theta);
  };
  const auto distance = [&](std::size_t i) {
    return (transmission.motors_from_joints(places[i].theta) -
            transmission.motors_from_joints(theta))
        .cwiseAbs()
        .maxCoeff();
  };
  while (!left.empty()) {
    std::sort(left.begin(), left.end(),
              [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); });
    const auto next =
        std::find_if(left.begin(), left.end(), [&](std::size_t i) { return !bar(i); });
    if (next == left.end()) break;
    plan.order.push_back(*next);
    theta = places[*next].theta;
    left.erase(next);
  }
  for (const std::size_t i : left)
    plan.barred.push_back(fmt::format("place '{}': {}", places[i].id, *bar(i)));
  return plan;
}

ForeseenCheck foresee_check(const CellSettings& cell,
                            const std::optional<VisionCalibration>& vision) {
  const CheckWays ways(cell, [&](const TipPose& tip) {
    return !vision ||
           lamps_from_tip(vision->workplane, vision->tool, vision->lamps.separation_m, tip);
  });
  const auto start = ways.start(cell.arm.home);
  if (!start)
    return {cell.arm.home,
            Refusal{"no place for the first moves lies in the workspace and the camera's view",
                    kWayOn, kCheck},
            true};
  ForeseenCheck foreseen{*start};
  for (int motor = 0; motor < 3; ++motor)
    foreseen.end = ways.with_motor_turned(foreseen.end, motor);
  const auto record = read_cell_health(cell);
  if (!record) return foreseen;
  const VisitPlan visits = ways.visits(foreseen.end, record->places);
  if (!visits.order.empty()) foreseen.end = record->places[visits.order.back()].theta;
  foreseen.refused = visits.order.empty();
  if (!visits.barred.empty())
    foreseen.doubt = Refusal{barred_text(visits.barred, record->places.size()), kWayOn, kCheck};
  return foreseen;
}

std::string barred_text(const std::vector<std::string>& barred, std::size_t places) {
  return fmt::format("{} of the {} places of the health file cannot be visited again ({}){}",
                     barred.size(), places, fmt::join(barred, "; "),
                     barred.size() == places
                         ? ""
                         : "; with fewer than four, a place at which the arm strayed passes for a "
                           "change of the cell");
}

}  // namespace planar
