#include "planar_servo/hardware/robot/planar_robot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// The least limit of speed (pulses/s) and acceleration (pulses/s^2). Drives take no limit of 0,
/// and a motor as slow as this counts as resting.
constexpr double kLeastLimit = 1.0;

Eigen::Vector3d scaled(const Eigen::Vector3d& velocity, const std::array<DriveLimits, 3>& rated) {
  double excess = 1.0;
  for (std::size_t i = 0; i < 3; ++i)
    excess = std::max(excess, std::abs(velocity[i]) / rated[i].speed_pulses_s);
  return velocity / excess;
}

/// Returns the present velocity of a motor that changes from one velocity to another with its
/// acceleration.
double velocity_now(const VelocityMove& last, std::size_t i, double now_s) {
  const double change = last.limits[i].acceleration_pulses_s2 * (now_s - last.t_s);
  return last.from[i] + std::clamp(last.velocity[i] - last.from[i], -change, change);
}

/// Returns the accelerations with which all motors make these changes of velocity in the same time,
/// which is the shortest that their limits allow.
Eigen::Vector3d in_one_time(const Eigen::Vector3d& changes,
                            const std::array<DriveLimits, 3>& rated) {
  double duration_s = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    duration_s = std::max(duration_s, std::abs(changes[i]) / rated[i].acceleration_pulses_s2);
  if (duration_s == 0.0) return Eigen::Vector3d::Zero();
  return changes.cwiseAbs() / duration_s;
}

double braking_way(double velocity, double acceleration) {
  return velocity * velocity / (2.0 * acceleration);
}

constexpr double kPollPeriod_s = 5e-3;
/// A move may take this many times its computed duration, plus a margin for the link.
constexpr double kTimeoutFactor = 2.0;
constexpr double kTimeoutMargin_s = 1.0;
/// Pauses between attempts to recover a lost drive; each is twice the one before.
constexpr double kFirstPause_s = 0.1;
constexpr double kLongestPause_s = 2.0;

std::string words_of(const DriveStatus& drive) {
  return drive.faults.empty() ? "it is switched off"
                              : fmt::format("{}", fmt::join(drive.faults, ", "));
}

[[noreturn]] void throw_unhomed(std::size_t joint) {
  throw DriveError({fmt::format("drive {} has lost its position", joint + 1), "home it first", "",
                    Cause::kDevice});
}

void require_certain(const std::array<DriveStatus, 3>& status) {
  for (std::size_t i = 0; i < 3; ++i)
    if (!status[i].position_certain) throw_unhomed(i);
}

[[noreturn]] void throw_stopped() {
  throw StopRequested("the arm was stopped as asked");
}

}  // namespace

VelocityMove velocity_move(const VelocityMove& last, double now_s,
                           const std::array<DriveStatus, 3>& status,
                           const Eigen::Vector3d& velocity, const std::array<DriveLimits, 3>& rated,
                           double hold_s) {
  VelocityMove move;
  move.t_s = now_s;
  move.velocity = scaled(velocity, rated);
  for (std::size_t i = 0; i < 3; ++i)
    if (status[i].moving) move.from[i] = velocity_now(last, i, now_s);
  const Eigen::Vector3d changing = in_one_time(move.velocity - move.from, rated);
  const Eigen::Vector3d braking = in_one_time(move.velocity, rated);
  for (std::size_t i = 0; i < 3; ++i) {
    const double acceleration = std::max({kLeastLimit, changing[i], braking[i]});
    const double position = status[i].position_pulses;
    const double v = move.velocity[i];
    const bool turns = std::abs(v) > kLeastLimit;
    double ahead = v * hold_s + std::copysign(braking_way(v, acceleration), v);
    if (!turns) {
      const double way = braking_way(move.from[i], acceleration);
      ahead = std::clamp(status[i].target_pulses - position, -way, way);
    }
    move.limits[i] = {std::max(kLeastLimit, std::abs(turns ? v : move.from[i])), acceleration};
    move.targets_pulses[i] = static_cast<std::int32_t>(std::lround(position + ahead));
  }
  return move;
}

PlanarRobot::PlanarRobot(const PlanarArm& arm, const Transmission& transmission, DriveGroup& drives,
                         Clock& clock)
    : arm_(arm), transmission_(transmission), drives_(drives), clock_(clock) {
  read_positions(status());
}

PlanarRobot::~PlanarRobot() {
  try {
    const auto status = this->status();
    if (std::any_of(status.begin(), status.end(), [](const auto& s) { return s.moving; }))
      drives_.halt();
  } catch (const std::exception&) {
    // A drive out of touch stops by its own command timeout.
  }
}

PlanarRobot::Status PlanarRobot::status() {
  Status status = drives_.status();
  for (std::size_t i = 0; i < 3 && by_hand_.empty(); ++i)
    if (status[i].stopped_by_hand)
      by_hand_ = fmt::format("drive {} reports: {}", i + 1, words_of(status[i]));
  return status;
}

template <typename Deed>
auto PlanarRobot::or_halt(const Deed& deed) {
  try {
    return deed();
  } catch (const std::exception& cause) {
    try {
      halt();
    } catch (const std::exception& error) {
      if (error.what() != std::string_view(cause.what()))
        throw_failure(fmt::format("{}; {}", cause.what(), error.what()));
    }
    throw;
  }
}

void PlanarRobot::energize() {
  drives_.reconnect();
  status();
  if (!by_hand_.empty()) throw_failure("");
  switch_on();
}

void PlanarRobot::switch_on() {
  by_hand_.clear();
  drives_.reconnect();
  drives_.set_limits(transmission_.rated_limits());
  velocity_control_ = false;
  drives_.energize();
  read_positions(require_well());
}

void PlanarRobot::throw_if_stopped() const {
  if (stopped()) throw_stopped();
}

std::vector<int> PlanarRobot::unhomed() {
  std::vector<int> joints;
  const auto status = this->status();
  for (int i = 0; i < 3; ++i)
    if (forgotten_[i] || !status[i].position_certain) joints.push_back(i);
  return joints;
}

std::optional<Pulses> PlanarRobot::known_pulses() const {
  const bool known = std::all_of(commanded_pulses_.begin(), commanded_pulses_.end(),
                                 [](const auto& pulses) { return pulses.has_value(); });
  return known ? std::optional(commanded_pulses()) : std::nullopt;
}

std::optional<Joints> PlanarRobot::known_joints() const {
  const auto pulses = known_pulses();
  return pulses ? std::optional(transmission_.joints_from_pulses(*pulses)) : std::nullopt;
}

Pulses PlanarRobot::commanded_pulses() const {
  Pulses pulses;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!commanded_pulses_[i]) throw_unhomed(i);
    pulses[i] = *commanded_pulses_[i];
  }
  return pulses;
}

std::optional<double> PlanarRobot::home_mark(int joint) const {
  const MotorDrive& motor = motor_drive(joint);
  return motor.home == HomeReference::kTaught ? std::optional(motor.home_rad) : std::nullopt;
}

void PlanarRobot::search_home(int joint) {
  const MotorDrive& motor = motor_drive(joint);
  if (const auto mark = home_mark(joint))
    throw DriveError(
        {fmt::format("drive {} has no home switch", joint + 1),
         fmt::format("turn it to its mark at {:.3f} deg, then say so (mark {} in planar-jog)",
                     *mark / kDegree, joint + 1),
         "", Cause::kMissing});
  if (homes_by_sight())
    throw DriveError(Refusal{"the drives are homed by sight, all at once",
                             "start a program that has the cell's calibrated vision with --home"});
  throw_if_stopped();
  require_well();
  or_halt([&] {
    drives_.start_homing(joint, motor.home == HomeReference::kForwardSwitch
                                    ? HomeDirection::kForward
                                    : HomeDirection::kReverse);
    wait_for(kHomingTimeout_s, [&](const auto& status) {
      throw_if_stopped();
      return !status[joint].homing;
    });
  });
  const DriveStatus found = status()[joint];
  if (!found.position_certain)
    throw DriveError(fmt::format("drive {} gave up its search for the home switch", joint + 1));
  drives_.set_position(joint, found.position_pulses + home_pulses(joint));
  forgotten_[joint] = false;
  read_positions(status());
}

void PlanarRobot::teach_home(int joint) {
  drives_.set_position(joint, home_pulses(joint));
  forgotten_[joint] = false;
  read_positions(status());
}

bool PlanarRobot::homes_by_sight() const {
  return motor_drive(0).home == HomeReference::kSight;
}

void PlanarRobot::set_joints(const Joints& theta) {
  const Pulses pulses = transmission_.pulses_from_joints(theta);
  for (int i = 0; i < 3; ++i) drives_.set_position(i, pulses[i]);
  forgotten_ = {};
  read_positions(status());
}

void PlanarRobot::forget_position() {
  try {
    drives_.forget_positions();
  } catch (const WorkError&) {
    // One that cannot be told is not heard when it says where it stands.
  }
  forgotten_.fill(true);
  commanded_pulses_ = {};
}

void PlanarRobot::recover(double patience_s) {
  const double deadline_s = clock_.now_s() + patience_s;
  for (double pause_s = kFirstPause_s;; pause_s = std::min(2.0 * pause_s, kLongestPause_s)) {
    try {
      return energize();
    } catch (const StoppedByHand&) {
      throw;
    } catch (const DriveError&) {
      if (clock_.now_s() + pause_s > deadline_s) throw;
    }
    for (const double until_s = clock_.now_s() + pause_s; clock_.now_s() < until_s;) {
      throw_if_stopped();
      clock_.sleep_for_s(kPollPeriod_s);
    }
    throw_if_stopped();
  }
}

std::optional<std::string> PlanarRobot::move_to(const Joints& theta, const Guard& guard) {
  if (const auto violation = transmission_.limit_violation(theta))
    throw WorkError("the arm refuses to move: " + *violation, Cause::kUnreachable);
  if (velocity_control_)
    throw WorkError(
        Refusal{"the arm is under velocity control", "end that before it moves to a position"});
  const Pulses target = transmission_.pulses_from_joints(theta);
  read_positions(require_ready());
  bool stops = false;
  std::optional<std::string> objection;
  const auto must_rest = [&] {
    stops = stopped();
    if (guard) objection = guard();
    return stops || objection;
  };
  if (!must_rest()) travel(target, must_rest);
  if (stops) throw_stopped();
  return objection;
}

void PlanarRobot::travel(const Pulses& target, const std::function<bool()>& must_rest) {
  const auto motors = [&](const Pulses& pulses) -> Eigen::Vector3d {
    return pulses.cast<double>().cwiseQuotient(transmission_.pulses_per_rad());
  };
  const double longest_s = transmission_.longest_move_s(motors(commanded_pulses()), motors(target));
  const double timeout_s = kTimeoutFactor * longest_s + kTimeoutMargin_s;
  or_halt([&] {
    drives_.set_targets({target[0], target[1], target[2]});
    for (std::size_t i = 0; i < 3; ++i) commanded_pulses_[i] = target[i];
    bool rests = false;
    wait_for(timeout_s, [&](const auto& now) {
      if ((rests = must_rest())) return true;
      require_certain(now);
      for (std::size_t i = 0; i < 3; ++i)
        if (now[i].moving || now[i].position_pulses != target[i]) return false;
      return true;
    });
    if (rests) brake();
  });
}

void PlanarRobot::brake() {
  const Pulses commanded = commanded_pulses();
  const auto rated = transmission_.rated_limits();
  std::array<std::int32_t, 3> stop_pulses;
  double longest_s = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double acceleration = rated[i].acceleration_pulses_s2;
    const double speed = speed_pulses_s_[i];
    const double way = speed * std::abs(speed) / (2.0 * acceleration);
    const double seen = seen_pulses_[i], target = commanded[i];
    stop_pulses[i] = static_cast<std::int32_t>(
        std::lround(std::clamp(seen + way, std::min(seen, target), std::max(seen, target))));
    longest_s = std::max(longest_s, std::abs(speed) / acceleration);
  }
  drives_.brake_towards(stop_pulses);
  wait_for_rest(longest_s);
}

Joints PlanarRobot::present_joints() {
  read_positions(status());
  return commanded_joints();
}

PlanarRobot::Status PlanarRobot::look_while_turning() {
  return or_halt([&] {
    Status status = require_ready();
    read_positions(status);
    return status;
  });
}

void PlanarRobot::turn(const VelocityLaw& velocity) {
  if (const auto refusal = drives_.stream_refusal())
    throw WorkError({"the drives cannot be turned at velocities: " + *refusal,
                     "move to positions instead", "", Cause::kDevice});
  if (stopped()) end_turning();
  throw_if_stopped();
  const Status status = look_while_turning();
  turn(status, velocity(commanded_joints()));
}

void PlanarRobot::turn(const Status& status, const Joints& theta_dot) {
  if (!theta_dot.allFinite())
    throw std::invalid_argument("velocities of the joints must be finite");
  const Eigen::Vector3d velocity =
      transmission_.pulses_per_rad().cwiseProduct(transmission_.motors_from_joints(theta_dot));
  const VelocityMove move = velocity_move(turning_, clock_.now_s(), status, velocity,
                                          transmission_.rated_limits(), kVelocityHold_s);
  const Pulses target(move.targets_pulses[0], move.targets_pulses[1], move.targets_pulses[2]);
  if (const auto violation =
          transmission_.limit_violation(transmission_.joints_from_pulses(target)))
    throw WorkError("the arm refuses this velocity: " + *violation, Cause::kUnreachable);
  or_halt([&] {
    drives_.set_limits(move.limits);
    drives_.set_targets(move.targets_pulses);
  });
  turning_ = move;
  velocity_control_ = true;
}

void PlanarRobot::end_turning() {
  turn(look_while_turning(), Joints::Zero());
  or_halt([&] {
    wait_for_rest(kVelocityHold_s);
    drives_.set_limits(transmission_.rated_limits());
    velocity_control_ = false;
  });
}

void PlanarRobot::halt() {
  std::optional<Refusal> failure;
  try {
    drives_.halt();
  } catch (const WorkError& error) {
    failure = error.refusal();
  }
  read_positions(status());
  if (failure) throw DriveError(*failure);
}

void PlanarRobot::throw_failure(const std::string& fault) const {
  if (by_hand_.empty()) throw DriveError(fault);
  throw StoppedByHand({fault.find(by_hand_.substr(by_hand_.find(": "))) != fault.npos
                           ? fault
                           : fault + (fault.empty() ? "" : "; ") + by_hand_,
                       "see to the machine, then `enable`, or start again", "", Cause::kStopped});
}

PlanarRobot::Status PlanarRobot::require_well(const char* does) {
  Status status = this->status();
  for (std::size_t i = 0; i < 3; ++i)
    if (!status[i].faults.empty() || !status[i].energized)
      throw_failure(fmt::format("drive {} {}: {}", i + 1, does, words_of(status[i])));
  return status;
}

PlanarRobot::Status PlanarRobot::require_ready() {
  Status status = require_well();
  require_certain(status);
  note_speeds(status);
  return status;
}

void PlanarRobot::wait_for(double timeout_s, const std::function<bool(const Status&)>& arrived) {
  const double deadline_s = clock_.now_s() + timeout_s;
  while (!arrived(status_under_way())) {
    if (clock_.now_s() > deadline_s)
      throw DriveError(fmt::format("the drives have not arrived after {:.1f} s", timeout_s));
    clock_.sleep_for_s(kPollPeriod_s);
  }
}

void PlanarRobot::wait_for_rest(double duration_s) {
  wait_for(kTimeoutFactor * duration_s + kTimeoutMargin_s, [](const auto& status) {
    return std::none_of(status.begin(), status.end(), [](const auto& s) { return s.moving; });
  });
  read_positions(status());
}

PlanarRobot::Status PlanarRobot::status_under_way() {
  Status status = require_well("failed on its way");
  note_speeds(status);
  return status;
}

void PlanarRobot::note_speeds(const Status& status) {
  const double now_s = clock_.now_s(), elapsed_s = now_s - seen_s_;
  const Eigen::Vector3d position(status[0].position_pulses, status[1].position_pulses,
                                 status[2].position_pulses);
  if (elapsed_s > 0.0) speed_pulses_s_ = (position - seen_pulses_) / elapsed_s;
  seen_pulses_ = position;
  seen_s_ = now_s;
}

const MotorDrive& PlanarRobot::motor_drive(int joint) const {
  return transmission_.settings().drives.at(joint);
}

std::int32_t PlanarRobot::home_pulses(int joint) const {
  return static_cast<std::int32_t>(
      std::lround(transmission_.pulses_per_rad()[joint] * motor_drive(joint).home_rad));
}

void PlanarRobot::read_positions(const Status& status) {
  for (std::size_t i = 0; i < 3; ++i) {
    commanded_pulses_[i].reset();
    if (status[i].answers && status[i].position_certain && !forgotten_[i])
      commanded_pulses_[i] = status[i].position_pulses;
  }
}

}  // namespace planar
