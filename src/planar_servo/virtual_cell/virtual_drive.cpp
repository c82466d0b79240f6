#include "planar_servo/virtual_cell/virtual_drive.h"

#include <algorithm>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

MotionState after(const MotionState& start, double acceleration, double duration_s) {
  return {start.position + (start.velocity + 0.5 * acceleration * duration_s) * duration_s,
          start.velocity + acceleration * duration_s};
}

constexpr double kRegularShare = 0.3, kRegular_s = kHour;

// A shaft that is turned from outside turns on until the next small step, if that comes so soon.
constexpr double kNextStep_s = 0.1;

}  // namespace

MotionProfile::MotionProfile(double start_s, const MotionState& start, double target,
                             const MotionLimits& limits)
    : end_(start), end_s_(start_s) {
  const double a = limits.acceleration;
  const double stop = start.position + start.velocity * std::abs(start.velocity) / (2.0 * a);
  const double sign = target >= stop ? 1.0 : -1.0;
  if (sign * start.velocity < 0.0) {
    append(sign * a, std::abs(start.velocity) / a);
    end_.velocity = 0.0;
  }
  const double speed = std::abs(end_.velocity);
  const double distance = std::abs(target - end_.position);
  const double peak = std::min(limits.speed, std::sqrt(a * distance + 0.5 * speed * speed));
  const double ramps = (std::abs(peak * peak - speed * speed) + peak * peak) / (2.0 * a);
  append(std::copysign(a, sign * (peak - speed)), std::abs(peak - speed) / a);
  if (peak > 0.0) append(0.0, std::max(0.0, distance - ramps) / peak);
  append(-sign * a, peak / a);
  end_ = {target, 0.0};
}

void MotionProfile::append(double acceleration, double duration_s) {
  phases_.push_back({end_s_, end_, acceleration});
  end_ = after(end_, acceleration, duration_s);
  end_s_ += duration_s;
}

MotionState MotionProfile::state_at(double t_s) const {
  if (t_s >= end_s_) return end_;
  const auto next = std::find_if(phases_.begin(), phases_.end(),
                                 [&](const Phase& phase) { return phase.start_s > t_s; });
  const Phase& phase = *(next == phases_.begin() ? next : next - 1);
  return after(phase.start, phase.acceleration, std::max(0.0, t_s - phase.start_s));
}

std::vector<double> MotionProfile::turning_points(double from_s, double to_s) const {
  std::vector<double> positions;
  for (const Phase& phase : phases_)
    if (phase.start_s > from_s && phase.start_s <= to_s) positions.push_back(phase.start.position);
  if (end_s_ > from_s && end_s_ <= to_s) positions.push_back(end_.position);
  return positions;
}

MotorWarmth::MotorWarmth(const ArmWarmingTruth& truth) : truth_(truth) {
  const double heat = kRegularShare + (1.0 - kRegularShare) * truth.holding_share;
  regular_ = after({}, heat, kRegular_s);
}

void MotorWarmth::work(double t_s, double turns_until_s, bool energized) {
  last_ = warmed(t_s);
  last_s_ = t_s;
  turns_until_s_ = turns_until_s;
  holding_ = energized ? truth_.holding_share : 0.0;
}

Warmth MotorWarmth::at(double t_s) const {
  const Warmth now = warmed(t_s);
  return {now.motor / regular_.motor, now.link / regular_.link};
}

Warmth MotorWarmth::warmed(double t_s) const {
  const double rests_s = std::clamp(turns_until_s_, last_s_, t_s);
  return after(after(last_, 1.0, rests_s - last_s_), holding_, t_s - rests_s);
}

Warmth MotorWarmth::after(const Warmth& from, double heat, double duration_s) const {
  const double motor_left = std::exp(-duration_s / truth_.motor_time_s);
  const double link_left = std::exp(-duration_s / truth_.link_time_s);
  const double behind = from.motor - heat;
  const double led = behind * truth_.motor_time_s / (truth_.motor_time_s - truth_.link_time_s);
  return {heat + behind * motor_left,
          heat + (from.link - heat - led) * link_left + led * motor_left};
}

Reducer::Reducer(const ReducerTruth& truth, double motor_rad, double gear_ratio)
    : truth_(truth),
      gear_ratio_(gear_ratio),
      motor_rad_(motor_rad),
      held_rad_(shaft_rad(motor_rad)) {}

void Reducer::follow(double motor_rad) {
  if (motor_rad != motor_rad_) turned_negative_ = motor_rad < motor_rad_;
  motor_rad_ = motor_rad;
  const double half = 0.5 * truth_.backlash_rad;
  const double shaft = shaft_rad(motor_rad);
  const double held = std::clamp(held_rad_, shaft - half, shaft + half);
  wind(held - held_rad_);
  held_rad_ = held;
}

double Reducer::output_rad() const {
  constexpr double kVariations = 2.6;  // of the play, in a turn
  double output = held_rad_ + truth_.zero_offset_rad;
  for (const Harmonic& h : truth_.eccentricity)
    output += h.amplitude * std::sin(h.order * held_rad_ + h.phase_rad);
  const double lost = 0.5 * truth_.backlash_variation * truth_.backlash_rad *
                      std::sin(kVariations * held_rad_) * (turned_negative_ ? 1.0 : -1.0);
  return output + lost + ripple_rad() + wound_rad_;
}

double Reducer::shaft_rad(double motor_rad) const {
  double error = 0.0;
  for (const Harmonic& h : truth_.microsteps)
    error += h.amplitude * std::sin(h.order * gear_ratio_ * motor_rad + h.phase_rad);
  return motor_rad + error / gear_ratio_;
}

double Reducer::ripple_rad() const {
  constexpr double kAhead = 0.7;  // radians by which the swelling is ahead and behind
  double ripple = 0.0;
  for (const Harmonic& h : truth_.ripple) {
    const double wave = h.order * gear_ratio_ * held_rad_ + h.phase_rad;
    const double swelling = held_rad_ + h.phase_rad + kAhead * std::sin(2.0 * held_rad_);
    ripple += h.amplitude * (1.0 + truth_.ripple_modulation * std::sin(swelling)) *
              std::sin(wave + truth_.ripple_skew * std::sin(wave));
  }
  return ripple;
}

void Reducer::wind(double turn_rad) {
  if (turn_rad == 0.0) return;
  const double full = std::copysign(truth_.hysteresis_rad, turn_rad);
  wound_rad_ = full + (wound_rad_ - full) * std::exp(-std::abs(turn_rad) / truth_.forgetting_rad);
}

VirtualDrive::VirtualDrive(const Clock& clock, const Settings& settings,
                           const ReducerTruth& reducer)
    : clock_(clock),
      settings_(settings),
      limits_(settings.rated_pulses),
      profile_(settings.home_pulses),
      reducer_(reducer, settings.home_pulses / settings.pulses_per_rad, settings.gear_ratio),
      followed_until_s_(clock.now_s()),
      target_pulses_(settings.home_pulses),
      counter_offset_pulses_(settings.counted_pulses - settings.home_pulses),
      position_certain_(settings.position_certain) {
  if (settings.warming) warmth_.emplace(*settings.warming);
}

void VirtualDrive::energize() {
  energized_ = true;
  if (warmth_) warmth_->work(clock_.now_s(), rests_since_s_, true);
}

void VirtualDrive::set_limits(const DriveLimits& limits) {
  const auto usable = [](double limit) { return std::isfinite(limit) && limit > 0.0; };
  if (!usable(limits.speed_pulses_s) || !usable(limits.acceleration_pulses_s2))
    throw std::invalid_argument("a drive's limits must be finite and positive");
  limits_.speed = std::min(limits.speed_pulses_s, settings_.rated_pulses.speed);
  limits_.acceleration =
      std::min(limits.acceleration_pulses_s2, settings_.rated_pulses.acceleration);
}

void VirtualDrive::set_target(std::int32_t target_pulses) {
  require_ready();
  homing_ = false;
  turn_to(target_pulses - counter_offset_pulses_);
}

void VirtualDrive::halt() {
  advance();
  if (moving()) {
    position_certain_ = homing_ = false;
    note_turning(clock_.now_s());
  }
  target_pulses_ = shaft_pulses();
  profile_ = MotionProfile(target_pulses_);
}

DriveStatus VirtualDrive::status() {
  if (homing_ && !moving()) {
    homing_ = false;
    set_position(0);
  }
  DriveStatus status;
  status.position_pulses = shaft_pulses() + counter_offset_pulses_;
  status.target_pulses = target_pulses_ + counter_offset_pulses_;
  status.energized = energized_;
  status.moving = moving();
  status.position_certain = position_certain_;
  status.homing = homing_;
  return status;
}

void VirtualDrive::start_homing(HomeDirection /*direction*/) {
  require_ready();
  position_certain_ = false;
  homing_ = true;
  turn_to(settings_.home_pulses);
}

void VirtualDrive::set_position(std::int32_t position_pulses) {
  if (moving()) throw WorkError("the virtual drive refuses a position: it moves", Cause::kDevice);
  counter_offset_pulses_ = position_pulses - shaft_pulses();
  position_certain_ = true;
}

void VirtualDrive::forget_position() {
  halt();
  position_certain_ = false;
}

void VirtualDrive::require_ready() const {
  if (!energized_)
    throw WorkError("the virtual drive refuses to move: it is not energized", Cause::kDevice);
}

void VirtualDrive::turn_to(std::int32_t shaft_target_pulses) {
  advance();
  const double now_s = clock_.now_s();
  const bool turns = moving() || shaft_target_pulses != shaft_pulses();
  if (turns) before_turning_();
  profile_ = MotionProfile(now_s, profile_.state_at(now_s), shaft_target_pulses, limits_);
  if (turns) note_turning(profile_.end_s());
  target_pulses_ = shaft_target_pulses;
}

void VirtualDrive::turn_shaft(std::int32_t pulses) {
  advance();
  target_pulses_ = pulses - (settings_.counted_pulses - settings_.home_pulses);
  if (target_pulses_ != shaft_pulses()) {
    before_turning_();
    rests_since_s_ = clock_.now_s();
    if (warmth_) warmth_->work(rests_since_s_, rests_since_s_ + kNextStep_s, true);
  }
  profile_ = MotionProfile(target_pulses_);
  advance();
}

double VirtualDrive::output_rad() {
  advance();
  return reducer_.output_rad();
}

std::optional<std::int32_t> VirtualDrive::rest_pulses() const {
  if (moving()) return std::nullopt;
  return shaft_pulses();
}

bool VirtualDrive::turned_negative() {
  advance();
  return reducer_.turned_negative();
}

Warmth VirtualDrive::warmth() const {
  return warmth_ ? warmth_->at(clock_.now_s()) : Warmth();
}

void VirtualDrive::note_turning(double until_s) {
  rests_since_s_ = until_s;
  if (warmth_) warmth_->work(clock_.now_s(), until_s, energized_);
}

void VirtualDrive::advance() {
  const double now_s = clock_.now_s();
  for (const double turning_pulses : profile_.turning_points(followed_until_s_, now_s))
    reducer_.follow(std::round(turning_pulses) / settings_.pulses_per_rad);
  reducer_.follow(shaft_pulses() / settings_.pulses_per_rad);
  followed_until_s_ = now_s;
}

std::int32_t VirtualDrive::shaft_pulses() const {
  return static_cast<std::int32_t>(std::lround(profile_.state_at(clock_.now_s()).position));
}

Eigen::Vector3d VirtualHardware::pulses_per_rad() const {
  return directions.cwiseProduct(pulses_per_motor_turn).cwiseProduct(gear_ratios) / (2.0 * kPi);
}

Eigen::Vector3i VirtualHardware::home_pulses() const {
  const Eigen::Vector3d motors(home_rad[0], home_rad[1] - (relative[0] ? home_rad[0] : 0.0),
                               home_rad[2] - (relative[1] ? home_rad[1] : 0.0));
  return pulses_per_rad().cwiseProduct(motors).array().round().cast<int>();
}

VirtualHardware as_built(const VirtualHardware& stated, const BuildTruth& build) {
  VirtualHardware built = stated;
  built.sense = build.sense.value_or(stated.sense);
  built.relative = build.relative.value_or(stated.relative);
  built.gear_ratios = build.gear_ratios.value_or(stated.gear_ratios);
  built.directions = build.directions.value_or(stated.directions);
  built.home_rad = build.home_rad.value_or(stated.home_rad);
  for (const auto& monument : build.monuments_B) {
    const auto same =
        std::find_if(built.monuments_B.begin(), built.monuments_B.end(),
                     [&](const auto& other) { return other.first == monument.first; });
    if (same == built.monuments_B.end())
      built.monuments_B.push_back(monument);
    else
      *same = monument;
  }
  return built;
}

BuildTruth build_as_stated(const VirtualHardware& stated) {
  return {stated.sense,      stated.relative, stated.gear_ratios,
          stated.directions, stated.home_rad, stated.monuments_B};
}

}  // namespace planar
