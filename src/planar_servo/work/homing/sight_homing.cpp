#include "planar_servo/work/homing/sight_homing.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/work/homing/posture_candidates.h"

namespace planar {
namespace {

constexpr char kByHand[] =
    "turn the arm by hand to where both lamps are in view and the elbow is bent by 10 degrees or "
    "more, well inside limits and workspace and clear of obstacles, and start again, or name marks "
    "under home (reference: taught), turn it to them and start with --at-marks";
constexpr char kMidway[] =
    "no pose tells more: name marks under home (reference: taught), turn the arm to them and start "
    "with --at-marks, or mount the lamps with their middle a millimetre beside joint 3's axis and "
    "calibrate again";
/// The turn of motor 2 that is looked at, and that of joint 3. By a quarter the middle of the lamps
/// moves by 2.8 times its distance from the end point in opposite senses; half a turn would tell
/// most, but limits of whole turns never allow it for both.
constexpr double kTestTurn = 0.7 * kDegree, kQuarter = 90.0 * kDegree;
constexpr int kMostTurns = 24;  // there and back again
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

/// What postures differ in, and the turn of a motor that tells it.
struct PostureQuestion {
  bool (*answer)(const PostureCandidate&);
  const char* what;
  const char* remedy;  ///< where no turn tells it
  int motor;
  double take_up, turn;  ///< what takes up the play of the gear, and what is then looked at
};

/// How a turn moves the middle of the lamps, by the postures that answer no and by those with yes.
using PostureMoves = std::array<std::vector<Eigen::Vector2d>, 2>;

/// How a move that was seen fits those of the postures.
struct MoveFit {
  std::array<double, 2> misses_m{HUGE_VAL, HUGE_VAL};  ///< of the best that answers no, and yes
  double allowed_m{0.0};                               ///< by scatter alone

  bool answer() const { return misses_m[1] < misses_m[0]; }
  bool tells() const {
    return misses_m[answer()] <= allowed_m && std::abs(misses_m[1] - misses_m[0]) >= allowed_m;
  }
};

class SightHoming {
 public:
  SightHoming(const CalibratedCell& cell, PlanarRobot& robot, LampTipSensor& sensor)
      : cell_(cell), robot_(robot), sensor_(sensor), seen_(seen_places(sensor, *cell.vision)) {
    left_ = posture_candidates(cell, seen_);
    if (left_.empty())
      throw WorkError({"no posture within the limits has its lamps where they are seen",
                       "bend the elbow by hand where the arm is stretched, and compare links' "
                       "lengths and limits in the cell file with the arm",
                       "", Cause::kContradiction});
  }

  /// Turns joints until one posture is left, and returns it.
  PostureCandidate single_posture() {
    tell_apart({[](const PostureCandidate& c) { return c.elbow == Elbow::kLeft; },
                "the elbow's side", kByHand, 1, cell_.settings.servo.approach_margin_rad,
                kTestTurn});
    tell_apart({[](const PostureCandidate& c) { return c.exchanged; }, "which lamp is which",
                kMidway, 2, 0.0, kQuarter});
    return left_.front();
  }

 private:
  /// Turns a motor where candidates differ in an answer, and keeps those that moved as seen.
  void tell_apart(const PostureQuestion& q) {
    if (const auto [no, yes] = moves_by(q, q.turn); no.empty() || yes.empty()) return;
    const double turn = telling_turn(q);
    if (q.take_up > 0.0) move(q.motor, std::copysign(q.take_up, turn));
    const PostureMoves moves = moves_by(q, turn);
    Eigen::Vector2d sum(0.0, 0.0);
    for (int n = 1;; ++n) {
      const double sense = n % 2 == 1 ? 1.0 : -1.0;
      const Eigen::Vector2d before = middle_of(seen_);
      move(q.motor, sense * turn);
      sum += sense * (middle_of(seen_) - before);
      const MoveFit fit = fit_of(moves, sum / n, n);
      const auto unlike = [&](const PostureCandidate& c) { return q.answer(c) != fit.answer(); };
      if (fit.tells())
        return void(left_.erase(std::remove_if(left_.begin(), left_.end(), unlike), left_.end()));
      if (n == kMostTurns) throw in_doubt(q, fit);
    }
  }

  /// Returns the first allowed turn by which postures that differ move the lamps differently.
  double telling_turn(const PostureQuestion& q) const {
    const auto turns = test_turns(cell_.planner, left_, q.motor, q.take_up, q.turn);
    if (turns.empty())
      throw WorkError(
          {fmt::format("homing by sight cannot tell {}: motor {} may turn in no sense by "
                       "a quarter of {:.3g} deg in every posture that is possible",
                       q.what, q.motor + 1, q.turn / kDegree),
           kByHand, "", Cause::kUnreachable});
    const auto foreseen = [&](double turn) {
      const PostureMoves moves = moves_by(q, turn);
      return fit_of(moves, moves[0].front(), kMostTurns);
    };
    for (const double turn : turns)
      if (foreseen(turn).tells()) return turn;
    throw in_doubt(q, foreseen(turns.front()));
  }

  PostureMoves moves_by(const PostureQuestion& q, double turn) const {
    const auto middle = [&](const PostureCandidate& c, double by) {
      const Joints theta = turned(cell_.planner.transmission(), c.theta, q.motor, by);
      return middle_of(lamps_at(*cell_.vision, cell_.planner.arm().forward(theta)));
    };
    PostureMoves moves;
    for (const PostureCandidate& c : left_)
      moves[q.answer(c)].emplace_back(middle(c, turn) - middle(c, 0.0));
    return moves;
  }

  /// Returns how the mean of `n` moves fits.
  MoveFit fit_of(const PostureMoves& moves, const Eigen::Vector2d& seen, int n) const {
    // A gear may turn by this share more or less within a small angle.
    constexpr double kGearShare = 0.05, kSigmas = 4.0;
    // Of a move: looks of moving air, and two stops of the arm as it was found, or of one whose
    // maker states a repeatability of 0.06 mm: those of small arms are 0.02 to 0.2 mm.
    const double stop_m = cell_.planner.found() ? cell_.planner.scatter_m() : 20e-6;
    MoveFit fit;
    for (std::size_t i = 0; i < 2; ++i)
      for (const Eigen::Vector2d& move : moves[i])
        fit.misses_m[i] = std::min(fit.misses_m[i], (seen - move).norm());
    // Moves that follow each other share a stop and a look.
    fit.allowed_m =
        kSigmas * std::hypot(10e-6, std::sqrt(2.0) * stop_m) * std::sqrt(2.0 * n - 1.0) / n +
        kGearShare * moves[0].front().norm();
    return fit;
  }

  static WorkError in_doubt(const PostureQuestion& q, const MoveFit& fit) {
    return WorkError(
        {fmt::format("homing by sight cannot tell {}: turns of motor {} bring the lamps "
                     "{:.3f} mm from where one answer has them and {:.3f} mm from "
                     "where the other does; {:.3f} mm would tell",
                     q.what, q.motor + 1, mm(fit.misses_m[0]), mm(fit.misses_m[1]),
                     mm(fit.allowed_m)),
         q.remedy, "", Cause::kInsufficient});
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
      candidate.theta = turned(cell_.planner.transmission(), candidate.theta, motor, turn);
    spdlog::info("homing by sight: motor {} turns by {:.3f} deg", motor + 1, turn / kDegree);
    go_to(left_.front().theta);
    seen_ = seen_places(sensor_, *cell_.vision);
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
    const double below = std::floor((motors[i] - limits[0] + kBeyondLimits) / (2.0 * kPi));
    const double above = std::floor((limits[1] + kBeyondLimits - motors[i]) / (2.0 * kPi));
    if (below + above == 0.0) continue;
    text += fmt::format("{}motor {} stands at {:.1f} deg, or whole turns from there",
                        text.empty() ? "" : ", ", i + 1, motors[i] / kDegree);
  }
  return text;
}

/// Takes up the play of the gears as every approach does, so that the arm stands as it did where it
/// was found. The motors stand as the posture says.
void take_up_play(const PostureCandidate& posture, const ServoSettings& settings,
                  PlanarRobot& robot, const LampTipSensor& sensor) {
  robot.set_joints(posture.theta);
  const ApproachWay way = approach_way(posture.planner, settings, posture.theta, posture.theta);
  if (way.refusal || way.barred)
    return spdlog::warn("homing by sight: no room to take up the gears' play here");
  if (const auto objection = arrive_by(way, robot, [&] { return sensor.fault(); }))
    throw WorkError(objection->reason, Cause::kDevice);
  robot.wait_for_s(settings.settle_s);
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
    const std::string turns = turns_text(cell, posture.theta);
    if (!turns.empty() && (!may_home || !may_home(Homing::kTurn, turns)))
      throw WorkError(
          {turns,
           "if these are the turns on which the motors stand, start with --nearest-turn (by hand: "
           "home nearest-turn)",
           "", Cause::kInsufficient});
    take_up_play(posture, cell.settings.servo, robot, sensor);
    const Joints theta = joints_seen(cell, posture, sensor);
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
