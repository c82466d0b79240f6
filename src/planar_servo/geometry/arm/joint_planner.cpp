#include "planar_servo/geometry/arm/joint_planner.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// Corrections by vision at a place may turn a motor this much further, radians: five millimetres
/// at 0.3 m.
constexpr double kCorrectionRoom = 1.0 * kDegree;

/// A plan for an arm as it was found brings it as near as this: metres, radians.
constexpr double kReached_m = 1e-6, kReachedTurn = 1e-6;

/// A stopped arm may come nearer by this, or by half of its clearance, metres.
constexpr double kFinestStop_m = 0.5e-3;

/// Returns the drives with the speeds and accelerations of a move by which motors turn so far.
std::array<MotorDrive, 3> drives_on(const Eigen::Vector3d& way,
                                    const TransmissionSettings& settings) {
  std::array<MotorDrive, 3> drives = settings.drives;
  if (!settings.moves_straight) return drives;
  const auto& [first, second, third] = settings.drives;
  const StraightPace pace =
      straight_pace(way, {first.max_speed_rad_s, second.max_speed_rad_s, third.max_speed_rad_s},
                    {first.max_acceleration_rad_s2, second.max_acceleration_rad_s2,
                     third.max_acceleration_rad_s2});
  for (std::size_t i = 0; i < 3; ++i) {
    const double length = std::abs(way[i]);
    if (length == 0.0) continue;
    drives[i].max_speed_rad_s = pace.speed * length;
    drives[i].max_acceleration_rad_s2 = pace.acceleration * length;
  }
  return drives;
}

/// The way of the arm while its motors make a move.
class Way {
 public:
  Way(const PlanarArm& arm, const Transmission& transmission, const Joints& from, const Joints& to)
      : arm_(arm),
        transmission_(transmission),
        from_(transmission.motors_from_joints(from)),
        to_(transmission.motors_from_joints(to)),
        drives_(drives_on(to_ - from_, transmission.settings())),
        moves_{move(0), move(1), move(2)} {}

  double duration_s() const { return std::max(moves_[0].duration_s(), moves_[1].duration_s()); }

  /// Returns how long motors 1 and 2 brake at most.
  double longest_braking_s() const {
    double longest_s = 0.0;
    for (int i = 0; i < 2; ++i)
      longest_s = std::max(longest_s, std::abs(moves_[i].speed_at(0.5 * moves_[i].duration_s())) /
                                          drives_[i].max_acceleration_rad_s2);
    return longest_s;
  }

  /// Returns where the motors are at a time, or so long after they were told then to stop. They
  /// turn no way back, whichever of the two grows.
  Eigen::Vector3d motors_at(double t_s, double braking_s = 0.0) const {
    Eigen::Vector3d motors;
    for (int i = 0; i < 3; ++i) {
      const double speed = moves_[i].speed_at(t_s);
      const double brakes = std::copysign(drives_[i].max_acceleration_rad_s2, speed);
      const double for_s = std::min(braking_s, speed / brakes);
      motors[i] = moves_[i].angle_at(t_s) + (speed - 0.5 * brakes * for_s) * for_s;
    }
    return motors;
  }
  Joints joints_at(double t_s) const { return transmission_.joints_from_motors(motors_at(t_s)); }
  Eigen::Vector2d point_at(double t_s) const { return arm_.forward(joints_at(t_s)).p; }

  /// Returns a length that the way of no part exceeds while motors turn so far. A joint turns by no
  /// more than its motors together.
  double length_bound_m(const Eigen::Vector3d& turns) const {
    double turned = 0.0, length = 0.0;
    for (int i = 0; i < 2; ++i) {
      const bool relative = i > 0 && transmission_.coupling_matrix()(1, 0) != 0.0;
      turned = (relative ? turned : 0.0) + std::abs(turns[i]);
      length += arm_.geometry().link_lengths_m[i] * turned;
    }
    return length;
  }
  double length_bound_m(double from_s, double to_s) const {
    return length_bound_m(motors_at(to_s) - motors_at(from_s));
  }

  /// Returns when, within an interval, the arm lies deepest beyond a border, to
  /// JointPlanner::kWayResolution_m, as long as that is deeper than at `best_s`. `depth_m(joints)`
  /// changes by no more than the end point, or any other part, moves.
  template <typename Depth>
  double deepest_s(const Depth& depth_m, double from_s, double to_s, double best_s) const {
    const double middle_s = 0.5 * (from_s + to_s);
    const double depth = depth_m(joints_at(middle_s));
    if (depth > depth_m(joints_at(best_s))) best_s = middle_s;
    const double reach = std::max(length_bound_m(from_s, middle_s), length_bound_m(middle_s, to_s));
    if (depth + reach <= std::max(0.0, depth_m(joints_at(best_s))) + JointPlanner::kWayResolution_m)
      return best_s;
    best_s = deepest_s(depth_m, from_s, middle_s, best_s);
    return deepest_s(depth_m, middle_s, to_s, best_s);
  }

  /// A span of time: its beginning and end.
  using Span = Eigen::Vector2d;

  /// Returns joints at which the arm lies beyond a border by more than
  /// JointPlanner::kWayResolution_m, at a time within a span or while it brakes since then; empty
  /// when there are none, but for what the arm does within `finest_m`.
  template <typename Depth>
  std::optional<Joints> deep_at(const Depth& depth_m, double finest_m, const Span& t_s,
                                const Span& braking_s) const {
    const Eigen::Vector3d first = motors_at(t_s[0], braking_s[0]);
    const Eigen::Vector3d middle = motors_at(t_s.mean(), braking_s.mean());
    const Eigen::Vector3d last = motors_at(t_s[1], braking_s[1]);
    const Joints theta = transmission_.joints_from_motors(middle);
    const double depth = depth_m(theta);
    if (depth > JointPlanner::kWayResolution_m) return theta;
    const double reach =
        length_bound_m((middle - first).cwiseAbs().cwiseMax((last - middle).cwiseAbs()));
    if (reach <= std::max(finest_m, JointPlanner::kWayResolution_m - depth)) return std::nullopt;
    const Eigen::Vector3d unstopped = motors_at(t_s[1], braking_s[0]);
    const bool splits_time = length_bound_m(unstopped - first) >= length_bound_m(last - unstopped);
    const Span& split = splits_time ? t_s : braking_s;
    for (const Span& half : {Span(split[0], split.mean()), Span(split.mean(), split[1])})
      if (auto deep =
              deep_at(depth_m, finest_m, splits_time ? half : t_s, splits_time ? braking_s : half))
        return deep;
    return std::nullopt;
  }

 private:
  MotorMove move(int motor) const { return {from_[motor], to_[motor], drives_[motor]}; }

  const PlanarArm& arm_;
  const Transmission& transmission_;
  Eigen::Vector3d from_, to_;  ///< of the motors
  std::array<MotorDrive, 3> drives_;
  std::array<MotorMove, 3> moves_;
};

}  // namespace

JointPlanner::JointPlanner(const PlanarArm& arm, const Transmission& transmission,
                           const Workspace& workspace, Elbow elbow, double approach_margin)
    : arm_(arm),
      transmission_(transmission),
      workspace_(workspace),
      elbow_(elbow),
      approach_margin_(approach_margin) {}

void JointPlanner::plan_for(FoundArm found) {
  found.form.sense = arm_.sense();
  found.form.joints_per_motor = transmission_.coupling_matrix().inverse();
  for (int i = 0; i < 3; ++i)
    found.form.gear_ratios[i] = transmission_.settings().drives[i].gear_ratio;
  found_ = std::move(found);
}

std::optional<std::string> JointPlanner::refusal(const Joints& theta) const {
  if (auto outside = workspace_.violation(arm_.forward(theta).p)) return outside;
  if (gap(theta).gap_m < 0.0) return touching(theta);
  return transmission_.limit_violation(theta);
}

std::optional<std::string> JointPlanner::sweep_refusal(const Joints& from, const Joints& to) const {
  const Way way(arm_, transmission_, from, to);
  for (const Border& border : workspace_.borders()) {
    const auto depth = [&](const Joints& theta) { return border.depth_m(arm_.forward(theta).p); };
    const double deepest_s = way.deepest_s(depth, 0.0, way.duration_s(), 0.0);
    const Eigen::Vector2d deepest = way.point_at(deepest_s);
    const double allowed = std::max(0.0, border.depth_m(way.point_at(0.0)));
    if (border.depth_m(deepest) > allowed + kWayResolution_m)
      return fmt::format(
          "the way there leads {:.3f} mm {} of {:.3f} mm about {}, at {}; go round by targets in "
          "between",
          mm(border.depth_m(deepest)), border.words, mm(border.radius_m), place_mm(border.p_B),
          place_mm(deepest));
  }
  if (workspace_.barriers.empty()) return std::nullopt;
  const std::vector<double> spared_m = overlaps_m(from);
  const auto depth = [&](const Joints& theta) { return -gap(theta, spared_m).gap_m; };
  if (const auto there = way.deep_at(depth, 0.0, {0.0, way.duration_s()}, {0.0, 0.0}))
    return "on the way there " + touching(*there, spared_m);
  return std::nullopt;
}

std::optional<std::string> JointPlanner::way_refusal(const Joints& from, const Joints& to) const {
  if (auto refusal = sweep_refusal(from, to)) return refusal;
  if (workspace_.barriers.empty()) return std::nullopt;
  if (auto refusal = refusal_within(from)) return refusal;
  const Way way(arm_, transmission_, from, to);
  const std::vector<double> spared_m = overlaps_m(from);
  const auto depth = [&](const Joints& theta) { return -gap(theta, spared_m).gap_m; };
  const double finest_m = std::max(kFinestStop_m, 0.5 * arm_.geometry().body.clearance_m);
  if (const auto there =
          way.deep_at(depth, finest_m, {0.0, way.duration_s()}, {0.0, way.longest_braking_s()}))
    return "an arm that is stopped on the way there: " + touching(*there, spared_m);
  return std::nullopt;
}

std::optional<std::string> JointPlanner::refusal_within(const Joints& theta) const {
  ArmBody axes = arm_.geometry().body;
  axes.link_widths_m.setZero();
  axes.tool_radius_m = axes.clearance_m = 0.0;
  const ArmGap nearest =
      smallest_gap(axes, workspace_.barriers, arm_.elbow_place(theta), arm_.forward(theta).p);
  if (nearest.gap_m > 0.0) return std::nullopt;
  return fmt::format(
      "{} stands within the obstacle {}, by the cell file, so that no way out is known to be free; "
      "correct obstacles, arm or home there, or turn the arm out by hand",
      nearest.part, workspace_.barriers[nearest.barrier].name);
}

std::vector<Eigen::Vector2d> JointPlanner::drawn_way(const Joints& from, const Joints& to) const {
  constexpr int kPieces = 24;
  const Way way(arm_, transmission_, from, to);
  std::vector<Eigen::Vector2d> places;
  for (int i = 0; i <= kPieces; ++i) places.push_back(way.point_at(way.duration_s() * i / kPieces));
  return places;
}

ArmGap JointPlanner::gap(const Joints& theta, const std::vector<double>& spared_m) const {
  return smallest_gap(arm_.geometry().body, workspace_.barriers, arm_.elbow_place(theta),
                      arm_.forward(theta).p, spared_m);
}

std::vector<double> JointPlanner::overlaps_m(const Joints& theta) const {
  if (gap(theta).gap_m >= 0.0) return {};
  std::vector<double> overlaps;
  for (const Barrier& barrier : workspace_.barriers)
    overlaps.push_back(std::max(0.0, -smallest_gap(arm_.geometry().body, {barrier},
                                                   arm_.elbow_place(theta), arm_.forward(theta).p)
                                          .gap_m));
  return overlaps;
}

std::string JointPlanner::touching(const Joints& theta, const std::vector<double>& spared_m) const {
  const ArmGap nearest = gap(theta, spared_m);
  return fmt::format("{} would come within {:.1f} mm of the obstacle {}, with the end point at {}",
                     nearest.part,
                     mm(std::max(0.0, nearest.gap_m + arm_.geometry().body.clearance_m)),
                     workspace_.barriers[nearest.barrier].name, place_mm(arm_.forward(theta).p));
}

TipPose JointPlanner::reached(const Joints& commanded) const {
  if (!found_) return arm_.forward(commanded);
  return found_->tip(transmission_.motors_from_joints(commanded));
}

JointPlan JointPlanner::plan(const TipPose& target, const Joints& near) const {
  const InverseResult inverse = arm_.inverse(target, elbow_, near);
  if (inverse.status != ReachStatus::kOk) return {{}, describe(inverse.status)};
  const auto branch = [&](const Transmission::Room& room) {
    return transmission_.branch_within_limits(inverse.theta, near, room);
  };
  const std::optional<Joints> roomy = branch({approach_margin_ + kCorrectionRoom, kCorrectionRoom});
  const Joints theta = roomy ? *roomy : branch({}).value_or(inverse.theta);
  if (!found_) return {theta, refusal(theta)};
  if (auto outside = workspace_.violation(target.p)) return {theta, outside};
  const JointPlan plan = plan_as_found(target, theta, elbow_);
  if (!plan.refusal && gap(plan.theta).gap_m < 0.0) return {plan.theta, touching(plan.theta)};
  return {plan.theta, plan.refusal ? plan.refusal : transmission_.limit_violation(plan.theta)};
}

JointPlan JointPlanner::plan_as_found(const TipPose& pose, Joints theta, Elbow elbow) const {
  constexpr int kSteps = 12;  // each is some ten times nearer than the one before
  TipPose aim = pose;
  for (int step = 0; step < kSteps; ++step) {
    const TipPose now = reached(theta);
    aim.p += pose.p - now.p;
    aim.phi += wrap_angle(pose.phi - now.phi);
    const InverseResult inverse = arm_.inverse(aim, elbow, theta);
    if (inverse.status != ReachStatus::kOk) return {{}, describe(inverse.status)};
    theta = inverse.theta;
  }
  const TipPose end = reached(theta);
  const double off_m = (pose.p - end.p).norm(), turned = wrap_angle(pose.phi - end.phi);
  if (off_m <= kReached_m && std::abs(turned) <= kReachedTurn) return {theta, std::nullopt};
  return {
      {},
      fmt::format("no joint angles were found that bring the arm, as it was found, to {}; the "
                  "last ones miss it by {:.3f} mm and {:.3f} deg: is arm_found that of this arm?",
                  place_mm(pose.p), mm(off_m), turned / kDegree)};
}

}  // namespace planar
