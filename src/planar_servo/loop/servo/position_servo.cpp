#include "planar_servo/loop/servo/position_servo.h"

#include <visp3/visual_features/vpGenericFeature.h>
#include <visp3/vs/vpAdaptiveGain.h>
#include <visp3/vs/vpServo.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// sin(3 deg). Nearer to a straight arm, a step takes 20 times as much turning as at best.
constexpr double kMinManipulability = 0.05;

constexpr Named<LawStatus> kLawStatuses[] = {
    {LawStatus::kOk, "ok"},
    {LawStatus::kSingular,
     "the arm is nearly straight or folded: its joints cannot correct in every direction"},
    {LawStatus::kUnreachable, "the measured or the desired point is out of reach"}};

/// Returns the end point as a ViSP feature, whose interaction matrix takes x and y from the twist.
vpGenericFeature tip_feature(const Eigen::Vector2d& p) {
  vpMatrix L(2, 6);
  L[0][0] = L[1][1] = 1.0;
  vpGenericFeature feature(2);
  feature.set_s(p.x(), p.y());
  feature.setInteractionMatrix(L);
  return feature;
}

vpMatrix twist_jacobian(const Eigen::Matrix2d& J) {
  vpMatrix twist(6, 2);
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 2; ++column) twist[row][column] = J(row, column);
  return twist;
}

void check(const ServoSettings& settings) {
  const auto require = [](bool holds, const char* rule) {
    if (!holds) throw std::invalid_argument(std::string("servo settings: ") + rule);
  };
  require(settings.gain > 0.0 && settings.gain <= 1.0, "gain must be in (0, 1]");
  require(settings.tolerance_m > 0.0, "tolerance must be positive");
  require(settings.orientation_tolerance > 0.0, "orientation tolerance must be positive");
  require(settings.max_iterations >= 0, "max_iterations must not be negative");
  require(settings.max_step_m > 0.0, "max_step must be positive");
  require(settings.settle_s >= 0.0, "settle time must not be negative");
  require(settings.frames_per_measurement >= 1, "frames_per_measurement must be at least 1");
  require(settings.approach_margin_rad > 0.0, "approach margin must be positive");
}

/// How far motors 1 and 2 turn before the arm returns to a target: after a move as long as one
/// between targets, what stuck or slipped does so anew.
constexpr double kWithdrawal = 5.0 * kDegree;

std::vector<double> errors_m(const std::vector<ServoStep>& steps) {
  std::vector<double> lengths;
  lengths.reserve(steps.size());
  for (const ServoStep& step : steps) lengths.push_back(step.error.norm());
  return lengths;
}

}  // namespace

const char* describe(LawStatus status) {
  return name_in(kLawStatuses, status);
}

LawStep jacobian_law(const PlanarArm& arm, const LawInput& input, double gain) {
  if (PlanarArm::manipulability(input.theta) < kMinManipulability)
    return {LawStatus::kSingular, {}};
  vpGenericFeature s = tip_feature(input.p);
  vpGenericFeature s_d = tip_feature(input.p_d);
  vpServo task;
  task.setServo(vpServo::EYEINHAND_L_cVe_eJe);
  task.setInteractionMatrixType(vpServo::CURRENT);
  task.setLambda(vpAdaptiveGain(gain, gain / 2.0, gain));
  task.addFeature(s, s_d);
  task.set_cVe(vpVelocityTwistMatrix());
  task.set_eJe(twist_jacobian(arm.jacobian(input.theta)));
  const vpColVector step = task.computeControlLaw();
  return {LawStatus::kOk, {step[0], step[1]}};
}

LawStep inverse_law(const PlanarArm& arm, const LawInput& input, double gain) {
  if (PlanarArm::manipulability(input.theta) < kMinManipulability)
    return {LawStatus::kSingular, {}};
  const auto solve = [&](const Eigen::Vector2d& p) {
    return arm.inverse({p, 0.0}, arm.elbow(input.theta), input.theta);
  };
  const InverseResult measured = solve(input.p), desired = solve(input.p_d);
  if (measured.status != ReachStatus::kOk || desired.status != ReachStatus::kOk)
    return {LawStatus::kUnreachable, {}};
  return {LawStatus::kOk, gain * (desired.theta - measured.theta).head<2>()};
}

PositionServo::PositionServo(const ServoSettings& settings, const GuardLimits& limits,
                             const JointPlanner& planner, PlanarRobot& robot, TipSensor& sensor,
                             Clock& clock, LandingModel* landings)
    : settings_(settings),
      limits_(for_tolerance(limits, settings.tolerance_m)),
      planner_(planner),
      robot_(robot),
      sensor_(sensor),
      clock_(clock),
      landings_(landings) {
  check(settings);
  const double play_m =
      settings.approach == Approach::kDirect ? play_allowance_m(planner.arm(), settings) : 0.0;
  limits_.play_m += play_m;
  if (landings != nullptr) estimator_.emplace(*landings, play_m);
}

ServoResult PositionServo::move_to(const TipPose& target, const Observer& observer,
                                   const Eigen::Vector2d& p_TE) {
  p_TE_ = p_TE;
  const double start_s = clock_.now_s();
  ServoResult result;
  result.target = target;
  const auto finish = [&](ServoStatus status, const std::string& reason) {
    result.status = status;
    result.reason = reason;
    result.duration_s = clock_.now_s() - start_s;
    return result;
  };
  begin_target();
  JointPlan plan = planner_.plan(target, robot_.commanded_joints());
  for (;; ++result.iterations) {
    if (plan.refusal) return finish(ServoStatus::kRefused, *plan.refusal);
    if (const auto obstacle = command(plan.theta))
      return finish(obstacle->refused ? ServoStatus::kRefused : ServoStatus::kLostCamera,
                    obstacle->reason);
    ServoStep& step = result.steps.emplace_back(measure(target, result.iterations));
    auto found = doubt_of(step);
    if (!found) found = estimate(step);
    if (observer) observer(step);
    if (found && may_have_strayed(*found, step)) {
      if (const auto obstacle = withdraw())
        return finish(ServoStatus::kLostCamera, obstacle->reason);
      continue;
    }
    if (found) {
      result.cell_in_doubt = found->of_cell;
      return finish(ServoStatus::kHeld, found->text());
    }
    if (const auto status = verdict(result.steps)) {
      result.cell_in_doubt = *status == ServoStatus::kDiverged;
      if (result.cell_in_doubt) robot_.halt();
      return finish(*status, reason_for(*status, step, settings_.orientation_tolerance,
                                        settings_.max_iterations));
    }
    plan = corrected_joints(step);
    if (!step.estimate || !step.estimate->seems_strayed) continue;
    if (const auto obstacle = withdraw()) return finish(ServoStatus::kLostCamera, obstacle->reason);
  }
}

std::optional<Obstacle> PositionServo::withdraw() {
  estimator_->begin_again();
  last_look_.reset();
  const Transmission& transmission = planner_.transmission();
  const Joints here = robot_.commanded_joints();
  for (const double way : {-kWithdrawal, kWithdrawal}) {
    const Joints away = transmission.joints_from_motors(transmission.motors_from_joints(here) +
                                                        Eigen::Vector3d(way, way, 0.0));
    if (approach_refusal(planner_, settings_, here, away)) continue;
    return arrive(robot_, planner_, settings_, away, [this] { return sensor_.fault(); });
  }
  return std::nullopt;
}

bool PositionServo::may_have_strayed(const Doubt& found, const ServoStep& step) const {
  return estimator_ && found.may_be_stray && step.iteration == 0 && settings_.max_iterations > 0;
}

void PositionServo::begin_target() {
  if (!estimator_) return;
  estimator_->begin();
  // Looks at one target are compared with one arm; what they taught serves the next target.
  if (const FoundArm* learned = landings_->learned_arm()) planner_.plan_for(*learned);
}

ServoStep PositionServo::measure(const TipPose& target, int iteration) {
  ServoStep step;
  step.iteration = iteration;
  step.target = target;
  step.theta_c = robot_.commanded_joints();
  step.pulses_c = robot_.commanded_pulses();
  step.measurement =
      sensor_.measure(planner_.arm().forward(step.theta_c), settings_.frames_per_measurement);
  TipMeasurement& measurement = step.measurement;
  if (measurement.ok() && !measurement.tip.p.allFinite())
    measurement = failed_look(TipStatus::kNotFinite, "not_finite", measurement.t_s);
  step.turn_error = wrap_angle(target.phi - measurement.tip.phi);
  if (measurement.ok() && !p_TE_.isZero() && points_right(step))
    step.target.p += (rotation2d(target.phi) - rotation2d(measurement.tip.phi)) * p_TE_;
  step.error = step.target.p - measurement.tip.p;
  step.stop_below_m = std::max(settings_.tolerance_m, pulse_size_m());
  if (!estimator_) step.stop_below_m = std::max(step.stop_below_m, 2.0 * measurement.noise_m);
  return step;
}

std::optional<ServoStatus> PositionServo::verdict(const std::vector<ServoStep>& steps) const {
  const ServoStep& last = steps.back();
  if (!last.measurement.ok())
    return last.measurement.status == TipStatus::kNoPicture ? ServoStatus::kLostCamera
                                                            : ServoStatus::kLostLamp;
  const bool diverged =
      last.estimate ? last.estimate->is_contradicted : diverges(errors_m(steps), last.stop_below_m);
  if (diverged) return ServoStatus::kDiverged;
  if (last.miss_m() < last.stop_below_m && points_right(last))
    return last.measurement.inside_map ? ServoStatus::kReached : ServoStatus::kOutsideMap;
  if (last.iteration == settings_.max_iterations || hopeless(last))
    return ServoStatus::kNotConverged;
  return std::nullopt;
}

bool PositionServo::points_right(const ServoStep& step) const {
  return std::abs(step.turn_error) <= settings_.orientation_tolerance;
}

bool PositionServo::hopeless(const ServoStep& step) const {
  return step.estimate && points_right(step) &&
         step.miss_m() <=
             nearest_expected_m(step.estimate->spread, settings_.max_iterations - step.iteration);
}

std::optional<Doubt> PositionServo::doubt_of(const ServoStep& step) {
  if (!step.measurement.ok()) return std::nullopt;
  const GuardedLook look{step.measurement, planner_.arm().forward(step.theta_c), arrived_s_};
  GuardLimits limits = limits_;
  if (estimator_) limits.scatter_m = estimator_->longest_jump_m();
  auto found = doubt(limits, look, last_look_ ? &*last_look_ : nullptr);
  if (!found) last_look_ = look;
  return found;
}

std::optional<Doubt> PositionServo::estimate(ServoStep& step) {
  if (!estimator_ || !step.measurement.ok()) return std::nullopt;
  step.estimate = estimator_->take(step, planner_.reached(step.theta_c).p);
  return landings_->doubt();
}

JointPlan PositionServo::corrected_joints(const ServoStep& step) const {
  const Eigen::Vector2d& wanted = step.estimate ? step.estimate->correction : step.error;
  const Eigen::Vector2d dp = wanted * std::min(1.0, settings_.max_step_m / wanted.norm());
  const Eigen::Vector2d p = step.believed_p();
  const LawInput input{step.theta_c, p, p + dp};
  const auto law = settings_.law == ServoLaw::kJacobian ? jacobian_law : inverse_law;
  const LawStep correction = law(planner_.arm(), input, settings_.gain);
  if (correction.status != LawStatus::kOk) return {{}, describe(correction.status)};
  Joints theta = step.theta_c;
  theta.head<2>() += correction.delta_theta;
  if (p_TE_.isZero() || !points_right(step)) theta[2] += planner_.arm().sense() * step.turn_error;
  return {theta, std::nullopt};
}

std::optional<Obstacle> PositionServo::command(const Joints& theta) {
  auto obstacle = arrive(robot_, planner_, settings_, theta, [this] { return sensor_.fault(); });
  if (obstacle) return obstacle;
  arrived_s_ = clock_.now_s();
  clock_.sleep_for_s(settings_.settle_s);
  return std::nullopt;
}

double PositionServo::pulse_size_m() const {
  const Transmission& transmission = planner_.transmission();
  const Eigen::Matrix2d J = planner_.arm().jacobian(robot_.commanded_joints());
  double size_m = 0.0;
  for (int i = 0; i < 2; ++i) {
    const Joints turned = transmission.joints_from_pulses(Pulses::Unit(i));
    size_m = std::max(size_m, (J * turned.head<2>()).norm());
  }
  return size_m;
}

}  // namespace planar
