#include "virtual_cell/virtual_drive.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/error.h"

namespace planar {

VirtualDrive::VirtualDrive(const Clock& clock, const Settings& settings,
                           const ReducerTruth& reducer)
    : clock_(clock),
      settings_(settings),
      limits_(settings.rated_pulses),
      profile_(settings.home_pulses),
      reducer_(reducer, settings.home_pulses / settings.pulses_per_rad),
      followed_until_s_(clock.now_s()),
      target_pulses_(settings.home_pulses) {}

void VirtualDrive::energize() {
  energized_ = true;
}

void VirtualDrive::set_limits(double max_speed_pulses_s, double max_acceleration_pulses_s2) {
  const auto usable = [](double limit) { return std::isfinite(limit) && limit > 0.0; };
  if (!usable(max_speed_pulses_s) || !usable(max_acceleration_pulses_s2))
    throw std::invalid_argument("a drive's limits must be finite and positive");
  limits_.speed = std::min(max_speed_pulses_s, settings_.rated_pulses.speed);
  limits_.acceleration = std::min(max_acceleration_pulses_s2, settings_.rated_pulses.acceleration);
}

void VirtualDrive::set_target(std::int32_t target_pulses) {
  if (!faults_.empty())
    throw WorkError("the virtual drive refuses a target: it reports '" + faults_.front() + "'");
  if (!energized_) throw WorkError("the virtual drive refuses a target: it is not energized");
  advance();
  const double now_s = clock_.now_s();
  profile_ = MotionProfile(now_s, profile_.state_at(now_s), target_pulses, limits_);
  target_pulses_ = target_pulses;
}

void VirtualDrive::halt() {
  advance();
  if (profile_.end_s() > clock_.now_s()) position_certain_ = false;
  target_pulses_ = position_pulses();
  profile_ = MotionProfile(target_pulses_);
}

DriveStatus VirtualDrive::status() {
  return {position_pulses(), target_pulses_, energized_, profile_.end_s() > clock_.now_s(),
          position_certain_, faults_};
}

void VirtualDrive::set_fault(const std::string& fault) {
  faults_.clear();
  if (fault.empty()) return;
  faults_.push_back(fault);
  halt();
}

double VirtualDrive::output_rad() {
  advance();
  return reducer_.output_rad();
}

void VirtualDrive::advance() {
  const double now_s = clock_.now_s();
  for (const double turning_pulses : profile_.turning_points(followed_until_s_, now_s))
    reducer_.follow(std::round(turning_pulses) / settings_.pulses_per_rad);
  reducer_.follow(position_pulses() / settings_.pulses_per_rad);
  followed_until_s_ = now_s;
}

std::int32_t VirtualDrive::position_pulses() const {
  return static_cast<std::int32_t>(std::lround(profile_.state_at(clock_.now_s()).position));
}

}  // namespace planar
