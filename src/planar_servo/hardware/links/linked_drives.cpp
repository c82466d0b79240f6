#include "planar_servo/hardware/links/linked_drives.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

namespace planar {
namespace {

/// Beyond the time that the motors need to brake.
constexpr double kBrakingMargin_s = 2.0;
constexpr std::chrono::milliseconds kBrakingPoll{2};

/// Returns how far two places are apart at most, where their difference may exceed 32 bits.
std::int64_t apart(const Pulses& a, const Pulses& b) {
  return (a.cast<std::int64_t>() - b.cast<std::int64_t>()).cwiseAbs().maxCoeff();
}

/// Throws DriveError for a sum beyond 32 bits: the machine would take it for a place on the other
/// side.
std::int32_t within_counts(std::int64_t sum, const std::string& name, int joint) {
  const auto count = static_cast<std::int32_t>(sum);
  if (count == sum) return count;
  throw DriveError(
      fmt::format("{}: drive {} would count {}, more than 32 bits hold", name, joint + 1, sum),
      Cause::kUnreachable);
}

}  // namespace

LinkedDrives::LinkedDrives(std::string name, const std::array<DriveLimits, 3>& rated, Open open,
                           int in_position)
    : name_(std::move(name)),
      rated_(rated),
      limits_(rated),
      open_(std::move(open)),
      in_position_(in_position) {
  this->open();
  if (!link_) throw DriveError(error_.at(name_));
}

LinkedDrives::~LinkedDrives() {
  try {
    halt();
  } catch (const std::exception&) {
    // Closing the link is all that is left to do.
  }
}

void LinkedDrives::open() {
  link_.reset();
  error_ = {};
  missed_.clear();
  goal_.reset();
  held_.reset();
  rest_.reset();
  homing_joint_.reset();
  for (Joint& joint : joints_) joint.certain = false;
  try {
    link_ = open_();
    state_ = link_->read();
    if (was_on_ && (state_.emergency || !state_.on))
      missed_ = fmt::format("{} since it was out of touch; `enable` clears this",
                            state_.emergency ? "its emergency stop is pressed"
                                             : "it is off, as after its power was cut,");
    was_on_ = false;
  } catch (const WorkError& error) {
    lose(error.refusal());
  }
}

void LinkedDrives::reconnect() {
  if (!link_) open();
}

void LinkedDrives::lose(const Refusal& why) {
  spdlog::warn(why.at(name_).text());
  link_.reset();
  error_ = why;
  homing_joint_.reset();
  for (Joint& joint : joints_) joint.certain = false;
}

template <typename Deed>
void LinkedDrives::command(const std::string& purpose, const Deed& deed) {
  if (link_) {
    try {
      return deed();
    } catch (const MachineRefusal& error) {
      throw DriveError(fmt::format("{} cannot {}: {}", name_, purpose, error.what()),
                       error.refusal().cause);
    } catch (const WorkError& error) {
      lose(error.refusal());
    }
  }
  throw DriveError(fmt::format("{} cannot {}: {}", name_, purpose, error_.text()), error_.cause);
}

void LinkedDrives::read() {
  if (!link_) return;
  try {
    take(link_->read());
  } catch (const MachineRefusal& error) {
    try {
      link_->stop();
      state_.moving = false;
    } catch (const WorkError&) {
      // It may move still.
    }
    lose(error.refusal());
  } catch (const WorkError& error) {
    lose(error.refusal());
  }
}

void LinkedDrives::take(const MachineState& state) {
  const int losses = std::exchange(state_, state).losses;
  const bool is_lost = state.losses != losses;
  if (is_lost)
    forget(fmt::format(": its losses went from {} to {}{}", losses, state.losses,
                       state.faults.empty() ? "" : ", " + state.faults.front()));
  const bool rests = !state.moving && !state.homing;
  if (rest_ || rests) check_rest();
  if (!rests) return;
  if (homing_joint_ && !is_lost && state.faults.empty())
    joints_[*homing_joint_] = {state.counts[*homing_joint_], true};
  homing_joint_.reset();
  judge_rest();
}

void LinkedDrives::forget(const std::string& why) {
  spdlog::warn(fmt::format("{}: its position is not certain any more{}", name_, why));
  for (Joint& joint : joints_) joint.certain = false;
}

void LinkedDrives::check_rest() {
  if (!rest_) rest_ = state_.counts;
  if (apart(state_.counts, *rest_) <= in_position_) return;
  const std::string why = fmt::format(
      "it stands at {} counts, where it rested at {}: it was restarted, or moved by somebody else",
      fmt::join(state_.counts, ", "), fmt::join(*rest_, ", "));
  forget(": " + why);
  if (state_.on) missed_ = why + "; `enable` clears this";
  rest_.reset();
}

void LinkedDrives::judge_rest() {
  const auto is_at = [&](const std::optional<Pulses>& target) {
    return target && apart(state_.counts, *target) <= in_position_;
  };
  if (is_at(goal_)) held_ = goal_;
  if (is_at(held_)) state_.counts = *held_;
  if (!goal_) return;
  if (state_.counts != *goal_ && state_.faults.empty())
    missed_ = fmt::format(
        "it {}came to rest at {} counts, where it was sent to {}: it has limits of its own there, "
        "lost steps, was stopped by somebody else, or braked because it was not asked for long; "
        "`enable` clears this",
        apart(state_.counts, from_) > in_position_
            ? ""
            : fmt::format("did not begin: look at {}; it ", link_->starter()),
        fmt::join(state_.counts, ", "), fmt::join(*goal_, ", "));
  goal_.reset();
}

void LinkedDrives::energize() {
  command("be switched on", [this] {
    take(link_->read());  // it may have been restarted
    if (state_.moving) brake_to_rest();
    rest_.reset();  // a motor may turn a little as it gets its current
    link_->switch_on();
    missed_.clear();
    take(link_->read());
    was_on_ = state_.on;
  });
}

void LinkedDrives::set_limits(const std::array<DriveLimits, 3>& limits) {
  require_within(limits, rated_);
  limits_ = limits;
}

void LinkedDrives::brake_to_rest() {
  try {
    link_->stop();
  } catch (const MachineRefusal& error) {
    throw WorkError(error.refusal());  // which closes the link: that stops it, if anything does
  }
  goal_.reset();
  homing_joint_.reset();
  double braking_s = 0.0;
  for (const DriveLimits& rated : rated_)
    braking_s = std::max(braking_s, rated.speed_pulses_s / rated.acceleration_pulses_s2);
  const std::chrono::duration<double> patience(kBrakingMargin_s + braking_s);
  const auto begun = std::chrono::steady_clock::now();
  for (take(link_->read()); state_.moving; take(link_->read())) {
    if (std::chrono::steady_clock::now() - begun > patience)
      throw WorkError(fmt::format("it still moves {:.0f} s after it was told to stop: {}",
                                  patience.count(), state_.mover),
                      Cause::kDevice);
    std::this_thread::sleep_for(kBrakingPoll);
  }
}

void LinkedDrives::require_ready() const {
  const auto refuse = [&](const std::string& why, Cause cause = Cause::kDevice) {
    throw DriveError(fmt::format("{} cannot move: {}", name_, why), cause);
  };
  if (!link_) refuse(error_.text(), error_.cause);
  if (!state_.faults.empty()) refuse(state_.faults.front());
  if (!missed_.empty()) refuse(missed_);
  if (state_.homing) refuse("it is being homed");
  if (!state_.on) refuse("it is not switched on");
  for (std::size_t i = 0; i < 3; ++i)
    if (!joints_[i].certain) refuse(fmt::format("the position of drive {} is not certain", i + 1));
}

void LinkedDrives::set_targets(const std::array<std::int32_t, 3>& targets_pulses) {
  read();
  require_ready();
  Pulses target;
  for (int i = 0; i < 3; ++i)
    target[i] = within_counts(std::int64_t{targets_pulses[i]} + joints_[i].zero, name_, i);
  if (goal_ == target) return;
  if (state_.moving) {
    halt();
    require_ready();
  }
  if (state_.counts == target) return;
  command("move", [&] {
    rest_.reset();
    from_ = state_.counts;
    state_.moving = true;  // it may, even if it gets out of touch now
    try {
      link_->go_to(target, limits_);
    } catch (const MachineRefusal&) {
      state_.moving = false;
      throw;
    }
    goal_ = target;
  });
}

void LinkedDrives::halt() {
  if (!link_ && !state_.moving) return;
  if (!link_) throw DriveError(name_ + " cannot be told to halt: it is out of touch");
  command("be told to halt", [this] { brake_to_rest(); });
}

std::array<DriveStatus, 3> LinkedDrives::status() {
  read();
  return {status_of(0), status_of(1), status_of(2)};
}

DriveStatus LinkedDrives::status_of(std::size_t joint) const {
  DriveStatus status;
  status.answers = link_ != nullptr;
  status.position_certain = joints_[joint].certain;
  if (!link_) {
    status.faults.push_back(error_.text());
    return status;
  }
  const auto pulses = [&](std::int64_t count) {
    return static_cast<std::int32_t>(count - joints_[joint].zero);
  };
  status.position_pulses = pulses(state_.counts[joint]);
  status.target_pulses = pulses(goal_.value_or(state_.counts)[joint]);
  status.energized = state_.on;
  status.moving = state_.moving;
  status.homing = homing_joint_ == joint;
  status.faults = state_.faults;
  if (!missed_.empty()) status.faults.push_back(missed_);
  const bool was_switched_off = was_on_ && !state_.on;
  status.stopped_by_hand = state_.stopped_by_hand || !missed_.empty() || was_switched_off;
  return status;
}

void LinkedDrives::start_homing(int joint, HomeDirection direction) {
  joints_.at(joint).certain = false;
  command("be homed", [&] {
    rest_.reset();
    state_.homing = state_.moving = true;
    link_->search_home(joint, direction);
    homing_joint_ = joint;
    goal_.reset();
  });
}

void LinkedDrives::set_position(int joint, std::int32_t position_pulses) {
  read();
  if (link_ && (state_.moving || state_.homing))
    throw DriveError(fmt::format("{} moves; it can be told where it stands only at rest", name_));
  const std::int64_t zero = std::int64_t{state_.counts[joint]} - position_pulses;
  const Joint told{within_counts(zero, name_, joint), true};
  command("take a position", [&] { joints_.at(joint) = told; });
}

void LinkedDrives::forget_positions() {
  halt();
  for (Joint& joint : joints_) joint.certain = false;
}

}  // namespace planar
