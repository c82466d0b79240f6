#include "planar_servo/virtual_cell/motion/virtual_drive.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

// A shaft that is turned from outside turns on until the next small step, if that comes so soon.
constexpr double kNextStep_s = 0.1;

}  // namespace

VirtualDrive::VirtualDrive(const Clock& clock, const Settings& settings,
                           const ReducerTruth& reducer)
    : clock_(clock),
      settings_(settings),
      limits_(settings.rated_pulses),
      profile_(settings.home_pulses),
      reducer_(reducer, settings.home_pulses / settings.pulses_per_rad, settings.gear_ratio),
      followed_until_s_(clock.now_s()),
      target_pulses_(settings.home_pulses),
      counter_offset_pulses_(settings.counted_pulses - settings.home_pulses) {
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
  status.faults = faults_;
  return status;
}

void VirtualDrive::start_homing(HomeDirection /*direction*/) {
  require_ready();
  position_certain_ = false;
  homing_ = true;
  turn_to(settings_.home_pulses);
}

void VirtualDrive::set_position(std::int32_t position_pulses) {
  if (moving()) throw WorkError("the virtual drive refuses a position: it moves");
  counter_offset_pulses_ = position_pulses - shaft_pulses();
  position_certain_ = true;
}

void VirtualDrive::require_ready() const {
  if (!faults_.empty())
    throw WorkError("the virtual drive refuses to move: it reports '" + faults_.front() + "'");
  if (!energized_) throw WorkError("the virtual drive refuses to move: it is not energized");
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

void VirtualDrive::set_fault(const std::string& fault) {
  faults_.clear();
  if (fault.empty()) return;
  faults_.push_back(fault);
  halt();
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

}  // namespace planar
