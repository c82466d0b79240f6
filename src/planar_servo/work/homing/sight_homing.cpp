#include "planar_servo/work/homing/sight_homing.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/loop/servo/motion_guard.h"

namespace planar {
namespace {

constexpr char kByHand[] =
    "turn the arm by hand to where both lamps are in view, well inside its limits and workspace, "
    "and start again, or name marks under home (reference: taught), turn it to them and start with "
    "--at-marks";
/// An arm may stand as far beyond its limits: they end up to 5 degrees before its stops, and zeros
/// and links are a little off.
constexpr double kBeyond = 6.0 * kDegree;
/// What takes up the play of a gear, and the turn that is then looked at.
constexpr double kTakeUp = 0.3 * kDegree, kTestTurn = 0.7 * kDegree;
/// Joint 3's turn that tells which lamp is which, where the end point is not midway between them:
/// the middle moves by 2.8 times its distance from there in opposite senses. Half a turn would tell
/// most, but limits of whole turns never allow it for both.
constexpr double kQuarter = 90.0 * kDegree;
/// Looks that are averaged: the air moves a single one by a few hundredths of a pixel.
constexpr int kLooks = 4;

/// Returns the lamps' places, averaged. Throws WorkError when they are not seen.
LampPlaces seen_places(LampTipSensor& sensor, const VisionCalibration& vision) {
  LampPlaces sum{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  std::optional<LampPlaces> first;
  for (int i = 0; i < kLooks; ++i) {
    auto seen = sensor.look_around();
    if (!seen)
      throw WorkError({"the two lamps are not seen, so that the arm cannot be homed by sight",
                       kByHand, "", Cause::kInsufficient});
    if (!first) first = seen;
    if (((*seen)[0] - (*first)[0]).norm() > ((*seen)[1] - (*first)[0]).norm())
      std::swap((*seen)[0], (*seen)[1]);
    for (std::size_t k = 0; k < 2; ++k) sum[k] += (*seen)[k] / kLooks;
  }
  // A map at the end point errs alike wherever joint 3 turns the lamps.
  const auto* field = vision.error_map ? std::get_if<LampField>(&*vision.error_map) : nullptr;
  return field != nullptr ? compensate(*field, sum).lamps_B : sum;
}

Eigen::Vector2d middle_of(const LampPlaces& lamps) {
  return 0.5 * (lamps[0] + lamps[1]);
}

/// A posture that the lamps in a picture allow.
struct PostureCandidate {
  Joints theta{0.0, 0.0, 0.0};  ///< with every motor on the turn within its limits nearest to home
  Elbow elbow{Elbow::kLeft};
  bool exchanged{false};  ///< the first of the lamps seen is lamp 2
};

/// Returns the postures of an arm whose lamps are at these places, in any order: both elbows, and
/// both orders of the lamps (theory section 20), where turns of the motors bring them within their
/// limits.
std::vector<PostureCandidate> posture_candidates(const CalibratedCell& cell,
                                                 const LampPlaces& lamps_B) {
  std::vector<PostureCandidate> candidates;
  for (const bool exchanged : {false, true}) {
    const TipPose tip = tip_from_places({lamps_B[exchanged ? 1 : 0], lamps_B[exchanged ? 0 : 1]},
                                        cell.vision->tool);
    for (const Elbow elbow : {Elbow::kLeft, Elbow::kRight}) {
      const InverseResult inverse = cell.planner.arm().inverse(tip, elbow, cell.settings.arm.home);
      if (inverse.status != ReachStatus::kOk) continue;
      const auto theta = cell.planner.transmission().branch_within_limits(
          inverse.theta, cell.settings.arm.home, {-kBeyond, -kBeyond});
      if (theta) candidates.push_back({*theta, elbow, exchanged});
    }
  }
  return candidates;
}

class SightHoming {
 public:
  SightHoming(const CalibratedCell& cell, PlanarRobot& robot, LampTipSensor& sensor)
      : cell_(cell), robot_(robot), sensor_(sensor), seen_(seen_places(sensor, *cell.vision)) {
    left_ = posture_candidates(cell, seen_);
    if (left_.empty())
      throw WorkError({"no posture within the limits has its lamps where they are seen",
                       "compare the links' lengths and limits in the cell file with the arm", "",
                       Cause::kContradiction});
  }

  /// Turns joints until one posture is left, takes up the play of the gears there as every approach
  /// does, so that the arm stands as it did where it was found, and returns it.
  PostureCandidate single_posture() {
    tell_apart(
        1, kTakeUp, kTestTurn, [](const PostureCandidate& c) { return c.elbow; },
        "the elbow's side");
    tell_apart(
        2, 0.0, kQuarter, [](const PostureCandidate& c) { return c.exchanged; },
        "which lamp is which");
    take_up_play();
    return left_.front();
  }

 private:
  /// Turns a motor where candidates differ in a property, and keeps those that moved as seen.
  template <typename Property>
  void tell_apart(int motor, double take_up, double turn, const Property& property,
                  const char* what) {
    const bool differ = std::any_of(left_.begin(), left_.end(), [&](const PostureCandidate& c) {
      return property(c) != property(left_.front());
    });
    if (!differ) return;
    const double sign = allowed_sign(motor, take_up + turn, what);
    if (take_up > 0.0) move(motor, sign * take_up);
    std::vector<Eigen::Vector2d> moves;  // that each posture predicts for the middle of the lamps
    moves.reserve(left_.size());
    for (const PostureCandidate& c : left_)
      moves.emplace_back(middle_at(turned(c.theta, motor, sign * turn)) - middle_at(c.theta));
    Eigen::Vector2d sum(0.0, 0.0);
    for (int n = 1;; ++n) {
      const double sense = n % 2 == 1 ? 1.0 : -1.0;
      const Eigen::Vector2d before = middle_of(seen_);
      move(motor, sense * sign * turn);
      sum += sense * (middle_of(seen_) - before);
      if (keeps_those_that_moved(moves, sum / n, n, property, what)) return;
    }
  }

  void take_up_play() {
    const Transmission& transmission = cell_.planner.transmission();
    const Joints theta = left_.front().theta;
    const ApproachWay way = approach_way(cell_.planner, cell_.settings.servo, theta, theta);
    const auto stays = [] {
      spdlog::warn("homing by sight: there is no room to take up the play of the gears here");
    };
    if (way.refusal || way.barred) return stays();
    const Eigen::Vector3d back =
        transmission.motors_from_joints(way.stops.front()) - transmission.motors_from_joints(theta);
    for (int i = 0; i < 3; ++i)
      if (!may_turn(theta, i, back[i])) return stays();
    robot_.set_joints(theta);
    for (const Joints& stop : way.stops) go_to(stop);
  }

  void go_to(const Joints& theta) {
    if (const auto objection = robot_.move_to(theta, [&] { return sensor_.fault(); }))
      throw WorkError(*objection, Cause::kDevice);
    robot_.wait_for_s(cell_.settings.servo.settle_s);
  }

  /// Turns a motor and lets all candidates follow.
  void move(int motor, double turn) {
    robot_.set_joints(left_.front().theta);
    for (PostureCandidate& candidate : left_)
      candidate.theta = turned(candidate.theta, motor, turn);
    spdlog::info("homing by sight: motor {} turns by {:.1f} deg", motor + 1, turn / kDegree);
    go_to(left_.front().theta);
    seen_ = seen_places(sensor_, *cell_.vision);
  }

  /// Keeps the postures with the property of the one that predicts the mean move of `n` turns best,
  /// where it tells. Throws WorkError where that is still in doubt and these were the last turns.
  template <typename Property>
  bool keeps_those_that_moved(const std::vector<Eigen::Vector2d>& moves,
                              const Eigen::Vector2d& seen, int n, const Property& property,
                              const char* what) {
    constexpr int kMostTurns = 24;  // there and back again
    // A gear may turn by this share more or less within a small angle.
    constexpr double kGearShare = 0.05, kSigmas = 4.0;
    // Of a move: looks of moving air, and two stops of the arm as it was found, or of one whose
    // maker states a repeatability of 0.06 mm: those of small arms are 0.02 to 0.2 mm.
    const double stop_m = cell_.planner.found() ? cell_.planner.scatter_m() : 20e-6;
    // Moves that follow each other share a stop and a look.
    const double scatter_m =
        kSigmas * std::hypot(10e-6, std::sqrt(2.0) * stop_m) * std::sqrt(2.0 * n - 1.0) / n;
    std::size_t best = 0;
    for (std::size_t i = 1; i < moves.size(); ++i)
      if ((seen - moves[i]).norm() < (seen - moves[best]).norm()) best = i;
    const double miss = (seen - moves[best]).norm();
    std::vector<PostureCandidate> kept;
    double next = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < moves.size(); ++i) {
      if (property(left_[i]) == property(left_[best]))
        kept.push_back(left_[i]);
      else
        next = std::min(next, (seen - moves[i]).norm());
    }
    const double allowed = scatter_m + kGearShare * moves[best].norm();
    if (miss <= allowed && next - miss >= allowed) {
      left_ = std::move(kept);
      return true;
    }
    if (n == kMostTurns)
      throw WorkError({fmt::format("homing by sight leaves a doubt about {}: the lamps moved by "
                                   "{:.3f} mm, {:.3f} mm from what one posture says and {:.3f} mm "
                                   "from what another does, where {:.3f} mm would tell",
                                   what, mm(seen.norm()), mm(miss), mm(next), mm(allowed)),
                       kByHand, "", Cause::kInsufficient});
    return false;
  }

  /// Returns where the middle of the lamps is in a posture.
  Eigen::Vector2d middle_at(const Joints& theta) const {
    return middle_of(lamps_at(*cell_.vision, cell_.planner.arm().forward(theta)));
  }

  Joints turned(const Joints& theta, int motor, double turn) const {
    const Transmission& transmission = cell_.planner.transmission();
    return transmission.joints_from_motors(transmission.motors_from_joints(theta) +
                                           turn * Eigen::Vector3d::Unit(motor));
  }

  /// Returns the sense in which all postures may make a turn.
  double allowed_sign(int motor, double turn, const char* what) const {
    for (const double sign : {1.0, -1.0})
      if (std::all_of(left_.begin(), left_.end(), [&](const PostureCandidate& candidate) {
            return may_turn(candidate.theta, motor, sign * turn);
          }))
        return sign;
    throw WorkError({fmt::format("{} cannot be told: motor {} may turn by {:.0f} deg in neither "
                                 "sense in every posture that is possible",
                                 what, motor + 1, turn / kDegree),
                     kByHand, "", Cause::kUnreachable});
  }

  bool may_turn(const Joints& theta, int motor, double turn) const {
    const Joints end = turned(theta, motor, turn);
    if (cell_.planner.transmission().limit_violation(end)) return false;
    if (cell_.planner.way_refusal(theta, end)) return false;
    const Eigen::Vector2d limits =
        cell_.settings.transmission.limits_rad[static_cast<std::size_t>(motor)];
    const double angle = cell_.planner.transmission().motors_from_joints(theta)[motor];
    // Nobody knows on which of its turns the motor stands.
    const double whole = 2.0 * kPi;
    const double highest = angle + whole * std::floor((limits[1] - angle) / whole);
    const double lowest = angle - whole * std::floor((angle - limits[0]) / whole);
    return highest + turn <= limits[1] && lowest + turn >= limits[0];
  }

  const CalibratedCell& cell_;
  PlanarRobot& robot_;
  LampTipSensor& sensor_;
  LampPlaces seen_;
  std::vector<PostureCandidate> left_;
};

/// Says on which turns motors may stand; empty where the limits leave one for each.
std::string turns_text(const CalibratedCell& cell, const Joints& theta) {
  const Eigen::Vector3d motors = cell.planner.transmission().motors_from_joints(theta);
  std::string text;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d limits =
        cell.settings.transmission.limits_rad[static_cast<std::size_t>(i)];
    const double below = std::floor((motors[i] - limits[0] + kBeyond) / (2.0 * kPi));
    const double above = std::floor((limits[1] + kBeyond - motors[i]) / (2.0 * kPi));
    if (below + above == 0.0) continue;
    text += fmt::format("{}motor {} stands at {:.1f} deg, or whole turns from there",
                        text.empty() ? "" : ", ", i + 1, motors[i] / kDegree);
  }
  return text;
}

/// Returns the joints at which the arm is seen, by the arm as it was found where it was.
Joints joints_seen(const CalibratedCell& cell, const PostureCandidate& posture,
                   LampTipSensor& sensor) {
  const JointPlanner& planner = cell.planner;
  const TipMeasurement seen = sensor.measure(planner.arm().forward(posture.theta),
                                             cell.settings.servo.frames_per_measurement);
  if (!seen.ok())
    throw WorkError({"the lamps are lost after homing by sight: " + seen.word, kByHand, "",
                     Cause::kInsufficient});
  const JointPlan plan = planner.plan_as_found(seen.tip, posture.theta, posture.elbow);
  if (plan.refusal)
    throw WorkError({"no joint angles lead to where the tool is seen: " + *plan.refusal, kByHand,
                     "", Cause::kContradiction});
  return plan.theta;
}

}  // namespace

void home_by_sight(const CalibratedCell& cell, PlanarRobot& robot, LampTipSensor& sensor,
                   const MayHome& may_home) {
  try {
    const PostureCandidate posture = SightHoming(cell, robot, sensor).single_posture();
    const Joints theta = joints_seen(cell, posture, sensor);
    const std::string turns = turns_text(cell, theta);
    if (!turns.empty() && (!may_home || !may_home(Homing::kTurn, turns)))
      throw WorkError(
          {turns,
           "if these are the turns on which the motors stand, start with --nearest-turn (by hand: "
           "home nearest-turn)",
           "", Cause::kInsufficient});
    robot.set_joints(theta);
    spdlog::info("homed by sight: joints {} deg", fixed(theta / kDegree, 3, " "));
    if (posture.elbow != cell.settings.arm.elbow)
      spdlog::warn(
          "the elbow is on the side on which the arm was not calibrated: for exact zeros "
          "turn it to the other one by hand and home again");
  } catch (...) {
    robot.forget_position();  // what was set on the way is a guess
    throw;
  }
}

}  // namespace planar
