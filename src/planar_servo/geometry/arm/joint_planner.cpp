#include "planar_servo/geometry/arm/joint_planner.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <utility>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// Corrections by vision at a place may turn a motor this much further, radians: five millimetres
/// at 0.3 m.
constexpr double kCorrectionRoom = 1.0 * kDegree;

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

  Joints joints_at(double t_s) const {
    return transmission_.joints_from_motors(
        {moves_[0].angle_at(t_s), moves_[1].angle_at(t_s), moves_[2].angle_at(t_s)});
  }
  Eigen::Vector2d point_at(double t_s) const { return arm_.forward(joints_at(t_s)).p; }

  /// Returns a length that the end point's way between two times does not exceed. No motor turns
  /// back, so a joint turns by no more than its motors together.
  double length_bound_m(double from_s, double to_s) const {
    double turned = 0.0, length = 0.0;
    for (std::size_t i = 0; i < 2; ++i) {
      const double turn = std::abs(moves_[i].angle_at(to_s) - moves_[i].angle_at(from_s));
      const bool relative = i > 0 && transmission_.coupling_matrix()(1, 0) != 0.0;
      turned = relative ? turned + turn : turn;
      length += arm_.geometry().link_lengths_m[i] * turned;
    }
    return length;
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

  /// Returns a time within an interval at which the arm lies deeper than `allowed_m`; empty when
  /// there is none but for JointPlanner::kWayResolution_m.
  template <typename Depth>
  std::optional<double> deeper_s(const Depth& depth_m, double allowed_m, double from_s,
                                 double to_s) const {
    const double middle_s = 0.5 * (from_s + to_s);
    const double depth = depth_m(joints_at(middle_s));
    if (depth > allowed_m + JointPlanner::kWayResolution_m) return middle_s;
    const double reach = std::max(length_bound_m(from_s, middle_s), length_bound_m(middle_s, to_s));
    if (depth + reach <= allowed_m + JointPlanner::kWayResolution_m) return std::nullopt;
    if (const auto early = deeper_s(depth_m, allowed_m, from_s, middle_s)) return early;
    return deeper_s(depth_m, allowed_m, middle_s, to_s);
  }

  /// Returns the joints at which motors come to rest that are told to stop at this time.
  Joints stopped_at(double t_s) const {
    Eigen::Vector3d motors;
    for (int i = 0; i < 3; ++i) {
      const double speed = moves_[i].speed_at(t_s);
      const double brakes = drives_[i].max_acceleration_rad_s2;
      motors[i] = moves_[i].angle_at(t_s) + 0.5 * speed * std::abs(speed) / brakes;
    }
    return transmission_.joints_from_motors(motors);
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
  if (const auto touches_s = way.deeper_s(depth, 0.0, 0.0, way.duration_s()))
    return "on the way there " + touching(way.joints_at(*touches_s), spared_m);
  return std::nullopt;
}

std::optional<std::string> JointPlanner::way_refusal(const Joints& from, const Joints& to) const {
  if (auto refusal = sweep_refusal(from, to)) return refusal;
  if (workspace_.barriers.empty()) return std::nullopt;
  const Way way(arm_, transmission_, from, to);
  const std::vector<double> spared_m = overlaps_m(from);
  constexpr int kStops = 64;
  for (int i = 1; i < kStops; ++i) {
    const Joints stop = way.stopped_at(way.duration_s() * i / kStops);
    if (-gap(stop, spared_m).gap_m > kWayResolution_m)
      return "an arm that is stopped on the way there: " + touching(stop, spared_m);
  }
  return std::nullopt;
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
  return {theta, std::nullopt};
}

}  // namespace planar
