#include "planar_servo/loop/servo/motion_guard.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/text.h"

namespace planar {
namespace {

/// A picture may seem older than the arm's rest by the uncertainty of the camera's clock.
constexpr double kClockUncertainty_s = 0.010;
/// Beside the play, the motion seen may differ from the motion commanded by a tenth of it, which is
/// ten times what links and reducers of a sound arm cause.
constexpr double kMotionShare = 0.1;

/// A stop misses by no more than the default limits allow.
constexpr double kFarthestStray_m = GuardLimits{}.distance_m;

constexpr char kAskCell[] = "planar-check-cell says what has moved";

std::optional<Doubt> old(const GuardedLook& look) {
  const double age_s = look.arrived_s - look.measurement.t_s;
  if (age_s <= kClockUncertainty_s) return std::nullopt;
  return Doubt{
      {fmt::format("the picture was taken {:.3f} s before the arm had come to rest", age_s), "", "",
       Cause::kInsufficient}};
}

std::optional<Doubt> noisy(const GuardLimits& limits, const TipMeasurement& m) {
  const double noise_m = 2.0 * m.noise_m;
  if (noise_m <= limits.noise_m) return std::nullopt;
  return Doubt{{fmt::format("vision is uncertain by +- {:.3f} mm", mm(noise_m)),
                fmt::format("allowed is {:.3f} mm: are the lamps dim or partly covered, or is the "
                            "exposure too short?",
                            mm(limits.noise_m)),
                "", Cause::kInsufficient}};
}

std::optional<Doubt> separated(const GuardLimits& limits, const TipMeasurement& m) {
  const double separation_m = (m.lamps_B[1] - m.lamps_B[0]).norm();
  const double off_m = separation_m - limits.separation_m;
  if (std::abs(off_m) <= limits.separation_tolerance_m) return std::nullopt;
  return Doubt{{fmt::format("the lamps are seen {:.3f} mm apart, but were {:.3f} +- {:.3f} mm "
                            "apart at the calibration: has a lamp moved on the tool? {}",
                            mm(separation_m), mm(limits.separation_m),
                            mm(limits.separation_tolerance_m), kAskCell),
                "", "", Cause::kContradiction},
               true};
}

std::optional<Doubt> displaced(const GuardLimits& limits, const GuardedLook& look) {
  const double off_m = (look.measurement.tip.p - look.commanded.p).norm();
  if (off_m <= limits.distance_m) return std::nullopt;
  return Doubt{
      {fmt::format("the tool is seen at {}, {:.2f} mm from where it was commanded, {}",
                   place_mm(look.measurement.tip.p), mm(off_m), place_mm(look.commanded.p)),
       fmt::format(
           "this cell allows {:.2f} mm: has the camera moved or a drive lost its position, or are "
           "the arm's links, gears, directions or coupling not as the cell file says? {}",
           mm(limits.distance_m), kAskCell),
       "", Cause::kContradiction},
      true,
      off_m <= kFarthestStray_m};
}

std::optional<Doubt> turned(const GuardLimits& limits, const GuardedLook& look) {
  const double off = wrap_angle(look.measurement.tip.phi - look.commanded.phi);
  if (std::abs(off) <= limits.turn) return std::nullopt;
  return Doubt{
      {fmt::format("the tool is seen turned by {:.2f} deg from where it was commanded",
                   off / kDegree),
       fmt::format("this cell allows {:.2f} deg: has joint 3 lost its zero, has a lamp moved, or "
                   "are direction or coupling of joint 3 not as the cell file says? {}",
                   limits.turn / kDegree, kAskCell),
       "", Cause::kContradiction},
      true};
}

std::optional<Doubt> overcorrected(const GuardLimits& limits, const TipMeasurement& m) {
  if (m.correction.norm() <= limits.correction_m) return std::nullopt;
  return Doubt{{fmt::format("the error map would correct by {:.3f} mm", mm(m.correction.norm())),
                fmt::format("within its region it never corrects by more than {:.3f} mm: record "
                            "training positions here",
                            mm(limits.correction_m)),
                "", Cause::kInsufficient}};
}

std::optional<Doubt> jumped(const GuardLimits& limits, const GuardedLook& look,
                            const GuardedLook& before) {
  const Eigen::Vector2d commanded = look.commanded.p - before.commanded.p;
  const Eigen::Vector2d seen = look.measurement.tip.p - before.measurement.tip.p;
  const double off_m = (seen - commanded).norm();
  if (off_m <= limits.play_m + limits.scatter_m + kMotionShare * commanded.norm())
    return std::nullopt;
  return Doubt{{fmt::format("the tool was seen to move by {}, the command was {}", place_mm(seen),
                            place_mm(commanded)),
                fmt::format("they differ by {:.3f} mm: does the camera see a reflection, has it "
                            "been touched, or does a joint slip? {}",
                            mm(off_m), kAskCell),
                "", Cause::kContradiction},
               true,
               off_m <= kFarthestStray_m};
}

/// Says why the arm must not go straight from `from` through these stops.
std::optional<std::string> refusal_through(const JointPlanner& planner,
                                           const std::vector<Joints>& stops, Joints from) {
  for (const Joints& stop : stops) {
    auto refusal = planner.transmission().limit_violation(stop);
    if (!refusal) refusal = planner.way_refusal(from, stop);
    if (refusal && stop != stops.back()) return "on the approach from one side, " + *refusal;
    if (refusal) return refusal;
    from = stop;
  }
  return std::nullopt;
}

/// Returns the same pose with motor 1 on other turns, for a way that is longer than a correction.
std::vector<Joints> other_turns(const Transmission& transmission, const Joints& from,
                                const Joints& theta) {
  constexpr double kLong = 20.0 * kDegree;
  const Eigen::Vector3d motors = transmission.motors_from_joints(theta);
  const Eigen::Vector3d way = motors - transmission.motors_from_joints(from);
  if (way.head<2>().cwiseAbs().maxCoeff() < kLong) return {};
  std::vector<Joints> turns;
  for (const double turn : {-2.0 * kPi, 2.0 * kPi}) {
    const Joints turned = transmission.joints_from_motors(motors + turn * Eigen::Vector3d::UnitX());
    if (!transmission.limit_violation(turned)) turns.push_back(turned);
  }
  return turns;
}

/// Returns the stops of a way round to a place; empty where there is none.
std::vector<Joints> stops_round(const JointPlanner& planner, const ServoSettings& settings,
                                const Joints& from, const Joints& theta) {
  const std::vector<Joints> approach = approach_stops(planner.transmission(), settings, theta);
  std::vector<Joints> stops = planner.way_round(from, approach.front());
  const std::vector<Joints> rest(approach.begin() + 1, approach.end());
  if (stops.empty() || refusal_through(planner, rest, approach.front())) return {};
  stops.insert(stops.end(), rest.begin(), rest.end());
  return stops;
}

}  // namespace

std::vector<Joints> approach_stops(const Transmission& transmission, const ServoSettings& settings,
                                   const Joints& theta) {
  if (settings.approach == Approach::kDirect) return {theta};
  const Eigen::Vector3d motors = transmission.motors_from_joints(theta);
  return {transmission.joints_from_motors(motors -
                                          Eigen::Vector3d::Constant(settings.approach_margin_rad)),
          theta};
}

ApproachWay approach_way(const JointPlanner& planner, const ServoSettings& settings,
                         const Joints& from, const Joints& theta) {
  if (auto refusal = planner.refusal(theta)) return {{}, refusal};
  const std::vector<Joints> straight = approach_stops(planner.transmission(), settings, theta);
  const auto barred = refusal_through(planner, straight, from);
  if (!barred) return {straight};
  if (!planner.has_barriers()) return {{}, barred};
  std::vector<Joints> ends{theta};
  for (const Joints& turned : other_turns(planner.transmission(), from, theta))
    ends.push_back(turned);
  for (const Joints& end : ends)
    if (std::vector<Joints> stops = stops_round(planner, settings, from, end); !stops.empty())
      return {stops, {}, barred};
  return {{}, barred};
}

double play_allowance_m(const PlanarArm& arm, const ServoSettings& settings) {
  return settings.approach_margin_rad * arm.geometry().link_lengths_m.sum();
}

std::optional<Obstacle> arrive(PlanarRobot& robot, const JointPlanner& planner,
                               const ServoSettings& settings, const Joints& theta,
                               const PlanarRobot::Guard& guard) {
  return arrive_by(approach_way(planner, settings, robot.commanded_joints(), theta), robot, guard);
}

std::optional<Obstacle> arrive_by(const ApproachWay& way, PlanarRobot& robot,
                                  const PlanarRobot::Guard& guard) {
  if (way.refusal) return Obstacle{true, *way.refusal};
  if (way.barred)
    spdlog::info(fmt::format("going round by {} stops: {}", way.stops.size() - 1, *way.barred));
  for (const Joints& stop : way.stops)
    if (const auto objection = robot.move_to(stop, guard)) return Obstacle{false, *objection};
  return std::nullopt;
}

bool wait_for_camera(const FrameSource& camera, const PlanarRobot& robot, Clock& clock,
                     const std::string& id, const std::string& reason, double deadline_s) {
  constexpr double kPoll_s = 0.05;
  const double lost_s = clock.now_s();
  spdlog::warn(fmt::format("{}: {}; the arm stands and waits", id, reason));
  while (camera.fault()) {
    if (clock.now_s() > deadline_s) return false;
    robot.throw_if_stopped();
    clock.sleep_for_s(kPoll_s);
  }
  if (clock.now_s() > deadline_s) return false;
  spdlog::info(fmt::format("{}: the camera delivers again after {:.1f} s; resuming", id,
                           clock.now_s() - lost_s));
  return true;
}

GuardLimits for_tolerance(GuardLimits limits, double tolerance_m) {
  const double coarser = std::max(1.0, tolerance_m / limits.noise_m);
  limits.noise_m *= coarser;
  limits.play_m *= coarser;
  return limits;
}

std::optional<Doubt> doubt(const GuardLimits& limits, const GuardedLook& look,
                           const GuardedLook* before) {
  if (auto found = old(look)) return found;
  if (auto found = noisy(limits, look.measurement)) return found;
  if (auto found = separated(limits, look.measurement)) return found;
  if (auto found = displaced(limits, look)) return found;
  if (auto found = turned(limits, look)) return found;
  if (auto found = overcorrected(limits, look.measurement)) return found;
  if (before != nullptr) return jumped(limits, look, *before);
  return std::nullopt;
}

bool diverges(const std::vector<double>& errors_m, double noise_m) {
  if (errors_m.size() < 3) return false;
  const auto last = errors_m.rbegin();
  return last[0] > last[1] && last[1] > last[2] && last[0] > last[2] + noise_m;
}

}  // namespace planar
