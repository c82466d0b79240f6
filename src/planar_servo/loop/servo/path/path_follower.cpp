#include "planar_servo/loop/servo/path/path_follower.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// A motor commanded back by less than this has not reversed: the corrections by vision tremble by
/// that much. 0.01 mm at an arm's length of 0.3 m.
constexpr double kTremble_rad = 3e-5;

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

/// A picture that arrives later than this is of no use to a motion, seconds.
constexpr double kRemembered_s = 2.0;

/// A joint's deviation is made good in this time, or in that between the last two commands if it
/// was longer: a joint that continued for longer would overshoot.
constexpr double kCatchUp_s = 0.1;
/// After its time is over, the end of a path is held this long for the joints to catch up.
constexpr double kEnd_s = 5.0 * kCatchUp_s;
/// The share by which each look changes the disturbance. It halves the noise of one picture.
constexpr double kLearning = 0.5;
/// A look is requested this long before the next exposure.
constexpr double kBeforeExposure_s = 0.005;

/// The rest of a drive's speed and acceleration is left to the corrections.
constexpr double kShareForPath = 0.9;

/// Watches the motors from step to step.
class MotorWatch {
 public:
  explicit MotorWatch(const JointPlanner& planner) : planner_(planner) {}

  /// Takes the joints one step later. Returns which motor cannot keep up, in words.
  std::optional<std::string> objection(const Joints& theta, PathDemand& demand) {
    const Eigen::Vector3d motors = planner_.transmission().motors_from_joints(theta);
    const Eigen::Vector3d speeds =
        steps_ == 0 ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : (motors - motors_) / kPathStep_s;
    std::optional<std::string> objection;
    const Eigen::Vector3d turns = (kPathStep_s / (2.0 * kPi) * speeds).array().round().matrix();
    if (!turns.isZero()) unwound_ = 2.0 * kPi * turns;
    for (int i = 0; i < 3 && !objection; ++i)
      objection =
          turns[i] != 0.0 ? std::optional(unwinding(i)) : objection_of(i, speeds[i], demand);
    motors_ = motors;
    speeds_ = speeds;
    ++steps_;
    return objection;
  }
  /// Returns the whole turns by which the motors would unwind at the objection, radians.
  const std::optional<Eigen::Vector3d>& unwound() const { return unwound_; }

 private:
  static std::string unwinding(int i) {
    return fmt::format(
        "motor {} would have to unwind a whole turn, because its limits end here: let the path "
        "begin elsewhere, divide it, or widen arm.joint_limits_deg",
        i + 1);
  }

  std::optional<std::string> objection_of(int i, double speed, PathDemand& demand) const {
    const MotorDrive& drive =
        planner_.transmission().settings().drives[static_cast<std::size_t>(i)];
    const double share = std::abs(speed) / drive.max_speed_rad_s;
    if (share > demand.speed_share) {
      demand.speed_share = share;
      demand.fastest_motor = i;
    }
    if (share > kShareForPath) return too_fast(i, "turn at", speed, drive.max_speed_rad_s, "deg/s");
    const double acceleration = (speed - speeds_[i]) / kPathStep_s;
    if (steps_ > 1 && std::abs(acceleration) > kShareForPath * drive.max_acceleration_rad_s2)
      return too_fast(i, "speed up by", acceleration, drive.max_acceleration_rad_s2, "deg/s^2");
    return std::nullopt;
  }

  static std::string too_fast(int i, const char* what, double asked, double most,
                              const char* unit) {
    return fmt::format(
        "motor {} would have to {} {:.1f} {}; on a path it does at most {:.1f} {}: "
        "ask for a lower speed, or lead the path farther away from the base",
        i + 1, what, std::abs(asked) / kDegree, unit, kShareForPath * most / kDegree, unit);
  }

  const JointPlanner& planner_;
  int steps_{0};
  Eigen::Vector3d motors_{0.0, 0.0, 0.0}, speeds_{0.0, 0.0, 0.0};
  std::optional<Eigen::Vector3d> unwound_;
};

/// Does what path_demand() does from one turn of each motor. Where one would unwind, `near` becomes
/// joints from which it would not.
PathDemand demand_from(const JointPlanner& planner, const Path& path, const PathTiming& timing,
                       Joints& near) {
  PathDemand demand;
  MotorWatch watch(planner);
  Joints theta = near;
  const auto steps = static_cast<int>(std::ceil(timing.duration_s() / kPathStep_s));
  for (int i = 0; i <= steps; ++i) {
    const double along_m = timing.along_m(i * kPathStep_s);
    const TipPose pose = path.at(along_m).pose;
    const JointPlan plan = planner.plan(pose, theta);
    theta = plan.theta;
    if (i == 0) demand.start = theta;
    demand.refusal = plan.refusal;
    if (!demand.refusal) demand.refusal = watch.objection(theta, demand);
    if (!demand.refusal) continue;
    demand.refusal = fmt::format("{:.1f} mm along the path, at {}: {}", mm(along_m),
                                 place_mm(pose.p), *demand.refusal);
    break;
  }
  if (watch.unwound()) {
    const Transmission& transmission = planner.transmission();
    near = transmission.joints_from_motors(transmission.motors_from_joints(demand.start) +
                                           *watch.unwound());
  }
  return demand;
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
  ServoSettings straight = settings, from_below = settings;
  straight.approach = Approach::kDirect;
  from_below.approach = Approach::kOneSide;
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

PathDemand path_demand(const JointPlanner& planner, const Path& path, const PathTiming& timing,
                       const Joints& near) {
  Joints from = near;
  const PathDemand nearest = demand_from(planner, path, timing, from);
  // Each motor may have to begin on another turn.
  for (int tried = 0; tried < 3 && from != near; ++tried) {
    const Joints before = from;
    const PathDemand demand = demand_from(planner, path, timing, from);
    if (!demand.refusal) return demand;
    if (from == before) break;
  }
  return nearest;
}

void JointHistory::add(double t_s, const Joints& theta) {
  samples_.push_back({t_s, theta});
  while (samples_.front().t_s < t_s - kRemembered_s) samples_.pop_front();
}

Joints JointHistory::at(double t_s) const {
  if (samples_.empty()) throw std::logic_error("no joints were taken");
  const auto after = std::find_if(samples_.begin(), samples_.end(),
                                  [&](const Sample& sample) { return sample.t_s >= t_s; });
  if (after == samples_.end()) return samples_.back().theta;
  if (after == samples_.begin()) return after->theta;
  const Sample& before = *(after - 1);
  const double share = (t_s - before.t_s) / (after->t_s - before.t_s);
  return before.theta + share * (after->theta - before.theta);
}

PathFollower::PathFollower(const ServoSettings& settings, const GuardLimits& limits,
                           const JointPlanner& planner, PlanarRobot& robot, TipSensor& sensor,
                           Clock& clock, const ExposureTiming& exposures)
    : limits_(for_tolerance(limits, settings.tolerance_m)),
      planner_(planner),
      robot_(robot),
      sensor_(sensor),
      clock_(clock),
      exposures_(exposures) {
  limits_.play_m += play_allowance_m(planner.arm(), settings);
}

Eigen::Vector2d PathFollower::Run::correction() const {
  if (!by_vision || !disturbance) return Eigen::Vector2d::Zero();
  return -*disturbance;
}

PathResult PathFollower::follow(const Path& path, const PathTiming& timing, bool by_vision,
                                const Observer& observer) {
  const double now_s = clock_.now_s();
  const Joints here = robot_.commanded_joints();
  Run run{path,
          timing,
          by_vision,
          std::numeric_limits<double>::infinity(),
          now_s,
          here,
          GearPlay(planner_.transmission(), play_rad_, here)};
  std::optional<PathResult> early;
  try {
    early = move_along(run, observer);
  } catch (...) {
    brake_after_fault();
    throw;
  }
  robot_.end_turning();
  PathResult result = early.value_or(PathResult{});
  if (!early && !run.inside_map)
    result = {ServoStatus::kOutsideMap,
              "the error map is not valid on the whole path: record training positions around it"};
  result.duration_s = clock_.now_s() - now_s;
  return result;
}

/// On the motors' ramps, so that they keep their positions.
void PathFollower::brake_after_fault() {
  try {
    robot_.end_turning();
  } catch (const std::exception&) {
    // The first fault is the one to tell.
  }
}

std::optional<PathResult> PathFollower::move_along(Run& run, const Observer& observer) {
  take_joints(run);
  if (auto end = look(run, observer)) return end;
  run.start_s = run.commanded_s = clock_.now_s();
  while (clock_.now_s() < run.start_s + run.waited_s + run.timing.duration_s() + kEnd_s) {
    if (auto end = move_until_exposure(run)) return end;
    if (auto end = look(run, observer)) return end;
  }
  return std::nullopt;
}

std::optional<PathResult> PathFollower::look(Run& run, const Observer& observer) {
  PathLook look = measure(run);
  auto end = objection(run, look);
  const TipMeasurement& measurement = look.measurement;
  if (measurement.ok() && !end) {
    const Eigen::Vector2d missed = measurement.tip.p - planner_.reached(look.theta).p;
    run.disturbance =
        run.disturbance ? *run.disturbance + kLearning * (missed - *run.disturbance) : missed;
    run.last_look = GuardedLook{measurement, planner_.arm().forward(look.theta), measurement.t_s};
    run.seen_s = measurement.t_s;
    run.inside_map = run.inside_map && measurement.inside_map;
    look.correction = run.correction();
  }
  if (observer) observer(look);
  return end;
}

PathLook PathFollower::measure(Run& run) {
  const JointPlan soon = joints_at(run, clock_.now_s() + exposures_.period_s);
  PathLook look;
  look.measurement = sensor_.measure(planner_.arm().forward(soon.theta), 1);
  if (look.measurement.ok() && !look.measurement.tip.p.allFinite())
    look.measurement = failed_look(TipStatus::kNotFinite, "not_finite", look.measurement.t_s);
  if (look.measurement.ok() && run.last_look && look.measurement.t_s <= run.seen_s)
    look.measurement =
        failed_look(TipStatus::kNoPicture, name(FrameStatus::kFrozen), look.measurement.t_s);
  take_joints(run);
  run.exposed_s = look.measurement.ok() ? look.measurement.t_s : clock_.now_s();
  const double middle_s = run.exposed_s + exposures_.exposure_s / 2.0;
  look.t_s = std::max(0.0, middle_s - run.start_s);
  look.along_m = run.along_m(middle_s);
  look.along_now_m = run.along_m(clock_.now_s());
  look.desired = run.path.at(look.along_m).pose;
  look.theta = run.history.at(middle_s);
  look.correction = run.correction();
  if (look.measurement.ok()) look.seen = run.path.offset(look.measurement.tip.p, look.along_m);
  return look;
}

std::optional<PathResult> PathFollower::objection(Run& run, const PathLook& look) const {
  const TipMeasurement& measurement = look.measurement;
  if (!measurement.ok()) {
    const double blind_s = clock_.now_s() - run.seen_s;
    if (run.last_look && blind_s < kLongestBlind_s) return std::nullopt;
    return PathResult{
        measurement.status == TipStatus::kNoPicture ? ServoStatus::kLostCamera
                                                    : ServoStatus::kLostLamp,
        fmt::format("the tool has not been seen for {:.1f} s: {}", blind_s, measurement.word)};
  }
  const GuardedLook guarded{measurement, planner_.arm().forward(look.theta), measurement.t_s};
  const auto found = doubt(limits_, guarded, run.last_look ? &*run.last_look : nullptr);
  if (!found) return std::nullopt;
  return PathResult{ServoStatus::kHeld, found->text(), found->of_cell};
}

std::optional<PathResult> PathFollower::move_until_exposure(Run& run) {
  const double next_s = run.exposed_s + exposures_.period_s - kBeforeExposure_s;
  for (;;) {
    if (auto failed = command(run)) return failed;
    if (clock_.now_s() + kPathStep_s > next_s) return std::nullopt;
    clock_.sleep_for_s(kPathStep_s);
  }
}

std::optional<PathResult> PathFollower::command(Run& run) {
  if (const auto fault = sensor_.fault()) return PathResult{ServoStatus::kLostCamera, *fault};
  const Joints theta = take_joints(run);
  const double now_s = clock_.now_s();
  run.waited_s += std::max(0.0, now_s - run.commanded_s - PlanarRobot::kVelocityHold_s);
  const JointPlan here = joints_at(run, now_s), next = joints_at(run, now_s + kPathStep_s);
  for (const JointPlan& plan : {here, next})
    if (plan.refusal)
      return PathResult{ServoStatus::kRefused, fmt::format("{:.1f} mm along the path: {}",
                                                           mm(run.along_m(now_s)), *plan.refusal)};
  if ((here.theta - run.near).cwiseAbs().maxCoeff() > kPi ||
      (next.theta - here.theta).cwiseAbs().maxCoeff() > kPi)
    return PathResult{ServoStatus::kRefused,
                      fmt::format("{:.1f} mm along the path a motor would unwind a whole turn",
                                  mm(run.along_m(now_s)))};
  if (auto behind = left_behind(run, here.theta, now_s)) return behind;
  run.near = here.theta;
  const double catch_up_s = std::max(kCatchUp_s, now_s - run.commanded_s);
  run.commanded_s = now_s;
  Joints velocity =
      (next.theta - here.theta) / kPathStep_s + (run.play.command(here.theta) - theta) / catch_up_s;
  robot_.turn([&](const Joints&) { return velocity; });
  return std::nullopt;
}

/// Where a picture or a drive came late, the arm may be behind by what it goes in the meantime.
std::optional<PathResult> PathFollower::left_behind(const Run& run, const Joints& wanted,
                                                    double now_s) const {
  const PlanarArm& arm = planner_.arm();
  const double behind_m = (arm.forward(wanted).p - arm.forward(run.history.at(now_s)).p).norm();
  const double way_m = run.along_m(now_s) - run.along_m(now_s - kLongestBlind_s);
  if (behind_m <= limits_.distance_m + way_m) return std::nullopt;
  return PathResult{
      ServoStatus::kHeld,
      fmt::format("{:.1f} mm along the path the drives are {:.2f} mm from where they were told to "
                  "be; this cell allows {:.2f} mm and the way of {:.1f} s: are they slower than "
                  "the cell file says, or held back?",
                  mm(run.along_m(now_s)), mm(behind_m), mm(limits_.distance_m), kLongestBlind_s),
      true};
}

JointPlan PathFollower::joints_at(const Run& run, double t_s) const {
  TipPose pose = run.path.at(run.along_m(t_s)).pose;
  pose.p += run.correction();
  return planner_.plan(pose, run.near);
}

Joints PathFollower::take_joints(Run& run) {
  Joints theta = robot_.present_joints();
  run.history.add(clock_.now_s(), run.play.behind(theta));
  return theta;
}

}  // namespace planar
