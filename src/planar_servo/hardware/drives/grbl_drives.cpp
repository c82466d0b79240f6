#include "planar_servo/hardware/drives/grbl_drives.h"

#include <fmt/format.h>

#include <cstdlib>

namespace planar {
namespace {

/// Grbl counts lengths in numbers of 24 bits and rounds several times; beyond this it loses pulses.
constexpr int kFarthest_pulses = 1 << 21;

}  // namespace

GrblDrives::GrblDrives(const GrblSettings& settings) : settings_(settings) {
  for (std::size_t i = 0; i < 3; ++i) speeds_pulses_s_[i] = axis(i).speed_pulses_s;
  open();
  if (!in_touch()) throw DriveError(error_.at(name()));
}

void GrblDrives::open() {
  forget();
  moved_ = false;
  try {
    axes_ = std::make_unique<GrblAxes>(settings_);
    losses_ = axes_->losses();
  } catch (const WorkError& error) {
    error_ = error.refusal();
  }
  poll();
}

void GrblDrives::reconnect() {
  if (!in_touch()) open();
}

void GrblDrives::require_touch(const std::string& purpose) const {
  if (!in_touch())
    throw DriveError(fmt::format("{} cannot {}: {}", name(), purpose, error_.text()), error_.cause);
}

/// The axes brake, as far as the board hears it.
void GrblDrives::lose(const Refusal& why) {
  error_ = why;
  moved_ = axes_->moving();
  axes_.reset();
  homing_joint_.reset();
  forget();
}

void GrblDrives::forget() {
  for (Joint& joint : joints_) joint.certain = joint.switch_found = false;
}

template <typename Deed>
void GrblDrives::command(const std::string& purpose, const Deed& deed) {
  require_touch(purpose);
  try {
    deed();
    heed_axes();
  } catch (const WorkError& error) {
    lose(error.refusal());
    require_touch(purpose);
  }
}

void GrblDrives::poll() {
  if (!in_touch()) return;
  try {
    axes_->poll();
    heed_axes();
  } catch (const WorkError& error) {
    lose(error.refusal());
  }
}

/// Updates the joints where the axes have lost their position, or a search has ended.
void GrblDrives::heed_axes() {
  if (losses_ != axes_->losses()) forget();
  losses_ = axes_->losses();
  if (!homing_joint_ || axes_->searching()) return;
  const std::size_t searched = *homing_joint_;
  homing_joint_.reset();
  if (!axes_->found_switches()) return;
  for (std::size_t i = 0; i < 3; ++i)
    joints_[i] = {axes_->here()[index(i)], i == searched, i != searched};
}

std::array<AxisLimits, 3> GrblDrives::axis_limits() const {
  std::array<AxisLimits, 3> limits;
  for (std::size_t i = 0; i < 3; ++i)
    limits[index(i)] = {axis(i).pulses_per_mm, speeds_pulses_s_[i] / axis(i).pulses_per_mm,
                        axis(i).acceleration_pulses_s2 / axis(i).pulses_per_mm};
  return limits;
}

AxisPulses GrblDrives::axis_pulses(const std::array<std::int32_t, 3>& joint_pulses) const {
  AxisPulses pulses;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int64_t wanted = std::int64_t{joint_pulses[i]} + joints_[i].zero_pulses;
    if (std::abs(wanted) > kFarthest_pulses)
      throw DriveError(
          fmt::format("{} cannot take drive {} to {} pulses from its origin; Grbl loses pulses "
                      "beyond {}: set fewer microsteps",
                      name(), i + 1, wanted, kFarthest_pulses),
          Cause::kUnreachable);
    pulses[index(i)] = static_cast<int>(wanted);
  }
  return pulses;
}

void GrblDrives::energize() {
  command("be switched on", [this] { axes_->unlock(); });
}

void GrblDrives::set_limits(const std::array<DriveLimits, 3>& limits) {
  std::array<DriveLimits, 3> rated;
  for (std::size_t i = 0; i < 3; ++i)
    rated[i] = {axis(i).speed_pulses_s, axis(i).acceleration_pulses_s2};
  require_within(limits, rated);
  for (std::size_t i = 0; i < 3; ++i) speeds_pulses_s_[i] = limits[i].speed_pulses_s;
}

void GrblDrives::set_targets(const std::array<std::int32_t, 3>& targets_pulses) {
  require_touch("move");
  for (std::size_t i = 0; i < 3; ++i)
    if (const auto& faults = axes_->faults(index(i)); !faults.empty())
      throw DriveError(fmt::format("{} cannot move: {}", name(), faults.front()));
  if (!axes_->unlocked() || axes_->searching())
    throw DriveError(fmt::format("{} cannot move: it is {}", name(),
                                 axes_->searching() ? "being homed" : "not switched on"));
  const AxisPulses target = axis_pulses(targets_pulses);
  command("move", [&] { axes_->go_to(target, axis_limits()); });
}

void GrblDrives::halt() {
  if (in_touch() ? !axes_->moving() : !moved_) return;
  try {
    command("be told to halt", [this] { axes_->halt(); });
  } catch (const DriveError& error) {
    throw DriveError(fmt::format("{}; what it has queued ends after {:.0f} ms", error.what(),
                                 grbl::kLongestRun_s * 1e3),
                     error.refusal().cause);
  }
}

std::array<DriveStatus, 3> GrblDrives::status() {
  poll();
  return {status_of(0), status_of(1), status_of(2)};
}

DriveStatus GrblDrives::status_of(std::size_t joint) const {
  DriveStatus status;
  status.answers = in_touch();
  status.position_certain = joints_[joint].certain;
  if (!in_touch()) {
    status.faults.push_back(error_.text());
    return status;
  }
  const std::string state = axes_->state_words();
  status.position_pulses = axes_->here()[index(joint)] - joints_[joint].zero_pulses;
  status.target_pulses = axes_->target()[index(joint)] - joints_[joint].zero_pulses;
  status.energized = axes_->unlocked() && state.empty();
  status.moving = axes_->moving();
  status.homing = homing_joint_ == joint;
  status.faults = axes_->faults(index(joint));
  if (!state.empty()) status.faults.push_back(state);
  status.stopped_by_hand = axes_->stopped_by_hand();
  return status;
}

void GrblDrives::start_homing(int joint, HomeDirection /*direction*/) {
  Joint& homed = joints_.at(joint);
  require_touch("be homed");
  if (!is_switch(axis(joint).home))
    throw DriveError(fmt::format("drive {} has no home switch in the cell file", joint + 1),
                     Cause::kMissing);
  if (axes_->moving() || !axes_->unlocked())
    throw DriveError(fmt::format("{} cannot be homed: it {}", name(),
                                 axes_->moving() ? "moves" : "is not switched on"));
  if (homed.switch_found) {
    homed.switch_found = false;
    homed.certain = true;
    return;
  }
  command("be homed", [this] { axes_->search_switches(); });
  homing_joint_ = joint;
}

void GrblDrives::set_position(int joint, std::int32_t position_pulses) {
  Joint& set = joints_.at(joint);
  poll();
  require_touch("take a position");
  if (axes_->moving())
    throw DriveError(fmt::format("{} moves; it can be told where it stands only at rest", name()));
  set = {axes_->here()[index(joint)] - position_pulses, true};
}

void GrblDrives::forget_positions() {
  forget();
  halt();
}

}  // namespace planar
