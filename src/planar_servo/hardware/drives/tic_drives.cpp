#include "planar_servo/hardware/drives/tic_drives.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

namespace planar {
namespace {

using tic::Command;

/// Setup takes longer than other transfers, because settings are written to EEPROM.
constexpr double kSetupTimeout_s = 1.6;
/// The time that a drive may take to switch on, to leave the normal state or to begin homing.
constexpr std::chrono::milliseconds kStatePatience{400};
constexpr std::chrono::milliseconds kStatePoll{10};

/// Puts the offset of a setting into the upper half of a request's value, the transfer's index.
constexpr std::uint32_t at_offset(std::size_t offset) {
  return static_cast<std::uint32_t>(offset) << 16;
}

}  // namespace

TicDrives::TicDrives(const std::array<TicSettings, 3>& settings) {
  double shortest_s = settings[0].command_timeout_s;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < i; ++k)
      if (settings[k].serial == settings[i].serial)
        throw std::invalid_argument("two joints name the drive " + settings[i].serial);
    shortest_s = std::min(shortest_s, settings[i].command_timeout_s);
    joints_[i].settings = settings[i];
  }
  transfer_timeout_s_ = shortest_s / 2.0;
  feed_period_s_ = shortest_s / 4.0;
  std::vector<std::string> faults;
  std::optional<Cause> cause;
  for (std::size_t i = 0; i < 3; ++i) {
    open(i);
    const Refusal& error = joints_[i].error;
    if (joints_[i].in_touch()) continue;
    faults.push_back(error.at(name(i)).text());
    cause = cause.value_or(error.cause) == error.cause ? error.cause : Cause::kDevice;
  }
  if (cause) throw DriveError(fmt::format("{}", fmt::join(faults, "\n")), *cause);
  feeder_ = std::thread([this] { feed_those_at_rest(); });
}

TicDrives::~TicDrives() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  feeder_.join();
  park();
}

std::string TicDrives::name(std::size_t joint) const {
  return fmt::format("drive {} ({})", joint + 1, joints_[joint].settings.serial);
}

void TicDrives::open(std::size_t i) {
  Joint& joint = joints_[i];
  joint.port.reset();
  joint.may_move = true;
  joint.goal.reset();
  joint.port = bus_.open(joint.settings.serial, joint.error);
  if (joint.port == nullptr) return;
  try {
    configure(i);
  } catch (const WorkError& error) {
    joint.error = error.refusal();
    return joint.port.reset();
  }
  const TicListing& tic = joint.port->listing;
  spdlog::debug(fmt::format("{} is a {} at {}, firmware {}, position {} ({})", name(i),
                            tic::product_name(tic.product_id), tic.device,
                            tic::firmware_name(tic.firmware), joint.last->position(),
                            joint.last->position_certain() ? "certain" : "uncertain"));
}

void TicDrives::configure(std::size_t i) {
  Joint& joint = joints_[i];
  const auto settings = set_up({{i, Command::kGetSettings, 0, tic::kSettingsBytes}}).front().data;
  if (const auto unfit = tic::unfitness(joint.port->listing.firmware, settings))
    throw WorkError(*unfit);
  set_timeout(i, settings);
  // What happened before this program began is over; what happened out of its touch is not.
  const Command read = joint.last ? Command::kGetVariables : Command::kGetVariablesAndClearErrors;
  take_status(joint, set_up({{i, read, 0, tic::StatusBlock::kBytes}}).front());
}

void TicDrives::set_timeout(std::size_t i, const std::vector<std::uint8_t>& settings) {
  const auto timeout_ms =
      static_cast<std::uint16_t>(std::lround(joints_[i].settings.command_timeout_s * 1e3));
  const auto as_wanted = [&](std::vector<std::uint8_t> bytes) {
    bytes[tic::kCommandTimeoutMs] = static_cast<std::uint8_t>(timeout_ms & 0xff);
    bytes[tic::kCommandTimeoutMs + 1] = static_cast<std::uint8_t>(timeout_ms >> 8);
    bytes[tic::kSoftErrorResponse] = tic::kResponseHaltAndHold;
    return bytes;
  };
  const std::vector<std::uint8_t> wanted = as_wanted(settings);
  if (wanted == settings) return;
  std::vector<Request> requests;
  for (std::size_t offset = 0; offset < wanted.size(); ++offset)
    if (wanted[offset] != settings[offset])
      requests.push_back({i, Command::kSetSetting, wanted[offset] | at_offset(offset)});
  spdlog::debug(
      fmt::format("{}: its command timeout is set to {} ms and stored", name(i), timeout_ms));
  requests.push_back({i, Command::kReinitialize});
  requests.push_back({i, Command::kGetSettings, 0, tic::kSettingsBytes});
  const auto stored = set_up(requests).back().data;
  if (as_wanted(stored) != stored)
    throw WorkError({"it does not store its command timeout", "replace it", "", Cause::kDevice});
}

std::vector<TicTransfer> TicDrives::perform(const std::vector<Request>& requests,
                                            double timeout_s) {
  std::vector<TicTransfer> transfers;
  for (const Request& request : requests) {
    const Joint& joint = joints_[request.joint];
    transfers.push_back({joint.port.get(), request.command, request.value,
                         std::vector<std::uint8_t>(request.bytes),
                         joint.port ? "" : joint.error.text()});
  }
  bus_.exchange(transfers, timeout_s);
  for (std::size_t i = 0; i < requests.size(); ++i) {
    Joint& joint = joints_[requests[i].joint];
    if (transfers[i].error.empty() || joint.port == nullptr) continue;
    joint.error = {transfers[i].error, "", "", Cause::kDevice};
    if (transfers[i].lost) joint.port.reset();
  }
  return transfers;
}

std::vector<TicTransfer> TicDrives::set_up(const std::vector<Request>& requests) {
  std::vector<TicTransfer> done = perform(requests, kSetupTimeout_s);
  for (const TicTransfer& transfer : done)
    if (!transfer.error.empty()) throw WorkError(transfer.error, Cause::kDevice);
  return done;
}

void TicDrives::require(const std::vector<Request>& requests, const std::string& what) {
  const auto done = perform(requests, transfer_timeout_s_);
  for (std::size_t i = 0; i < requests.size(); ++i)
    if (!done[i].error.empty())
      throw DriveError(
          fmt::format("{} cannot be told to {}: {}", name(requests[i].joint), what, done[i].error));
}

void TicDrives::take_status(Joint& joint, const TicTransfer& transfer) {
  if (!transfer.error.empty()) return;
  tic::StatusBlock::Bytes bytes{};
  std::copy(transfer.data.begin(), transfer.data.end(), bytes.begin());
  joint.last.emplace(bytes);
  joint.error = {};
  if (joint.goal == joint.last->position()) joint.goal.reset();
  joint.may_move = joint.last->moving() || joint.goal.has_value();
}

void TicDrives::read_status(Command read) {
  std::vector<Request> requests;
  for (std::size_t i = 0; i < 3; ++i) {
    requests.push_back({i, read, 0, tic::StatusBlock::kBytes});
    requests.push_back({i, Command::kResetCommandTimeout});
  }
  const auto done = perform(requests, transfer_timeout_s_);
  for (std::size_t i = 0; i < 3; ++i)
    if (done[2 * i + 1].error.empty()) take_status(joints_[i], done[2 * i]);
}

std::array<DriveStatus, 3> TicDrives::status() {
  const std::lock_guard lock(mutex_);
  read_status();
  std::array<DriveStatus, 3> status;
  for (std::size_t i = 0; i < 3; ++i) {
    if (joints_[i].in_touch()) {
      status[i] = joints_[i].last->drive_status();
      continue;
    }
    status[i].answers = false;
    status[i].position_certain = false;
    status[i].faults.push_back(joints_[i].error.text());
  }
  return status;
}

template <typename Condition>
bool TicDrives::read_until(const Condition& holds) {
  const auto deadline = std::chrono::steady_clock::now() + kStatePatience;
  for (;;) {
    read_status();
    if (holds()) return true;
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(kStatePoll);
  }
}

void TicDrives::energize() {
  const std::lock_guard lock(mutex_);
  read_status(Command::kGetVariablesAndClearErrors);
  std::vector<Request> requests;
  for (std::size_t i = 0; i < 3; ++i) {
    Joint& joint = joints_[i];
    // It would go to where it stood when it was in touch.
    if (!joint.in_touch())
      throw DriveError(
          fmt::format("{} cannot be told to switch on: {}", name(i), joint.error.text()));
    if (joint.ready()) continue;
    // A Tic keeps its last target through an error and would resume its move without a new one.
    const auto here = static_cast<std::uint32_t>(joint.last->position());
    requests.push_back({i, Command::kSetTargetPosition, here});
    for (const Command command :
         {Command::kClearDriverError, Command::kEnergize, Command::kExitSafeStart})
      requests.push_back({i, command});
    joint.goal.reset();
  }
  require(requests, "switch on");
  read_until([this] {
    return std::all_of(joints_.begin(), joints_.end(),
                       [](const Joint& joint) { return joint.ready(); });
  });
}

void TicDrives::set_limits(const std::array<DriveLimits, 3>& limits) {
  const std::lock_guard lock(mutex_);
  std::vector<Request> requests;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t acceleration = tic::acceleration_units(limits[i].acceleration_pulses_s2);
    requests.push_back({i, Command::kSetMaxSpeed, tic::speed_units(limits[i].speed_pulses_s)});
    requests.push_back({i, Command::kSetMaxAcceleration, acceleration});
    requests.push_back({i, Command::kSetMaxDeceleration, acceleration});
  }
  require(requests, "keep its limits");
}

void TicDrives::set_targets(const std::array<std::int32_t, 3>& targets_pulses) {
  const std::lock_guard lock(mutex_);
  std::vector<Request> requests;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!joints_[i].ready())
      throw DriveError(
          fmt::format("{} cannot take a target: {}", name(i),
                      joints_[i].in_touch() ? "it is not switched on" : joints_[i].error.text()));
    requests.push_back(
        {i, Command::kSetTargetPosition, static_cast<std::uint32_t>(targets_pulses[i])});
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (targets_pulses[i] == joints_[i].last->position() && !joints_[i].may_move) continue;
    joints_[i].goal = targets_pulses[i];
    joints_[i].may_move = true;
  }
  require(requests, "move");
}

void TicDrives::halt() {
  const std::lock_guard lock(mutex_);
  const std::string failures = halt_what_moves();
  if (!failures.empty()) throw DriveError(failures);
}

void TicDrives::forget_positions() {
  const std::lock_guard lock(mutex_);
  // A Tic that is told to halt takes its position for uncertain, also at rest [Tic user's guide].
  for (Joint& joint : joints_) joint.may_move = true;
  const std::string failures = halt_what_moves();
  if (!failures.empty()) throw DriveError(failures);
}

std::string TicDrives::halt_what_moves() {
  std::vector<Request> requests;
  for (std::size_t i = 0; i < 3; ++i)
    if (joints_[i].may_move) requests.push_back({i, Command::kHaltAndHold});
  std::string failures;
  for (const bool again : {true, false}) {
    const auto done = perform(requests, transfer_timeout_s_);
    std::vector<Request> failed;
    for (std::size_t k = 0; k < done.size(); ++k) {
      Joint& joint = joints_[requests[k].joint];
      if (done[k].error.empty()) {
        joint.may_move = false;
        joint.goal.reset();
      } else if (again && joint.port != nullptr) {
        failed.push_back(requests[k]);
      } else {
        failures += fmt::format(
            "{}{} cannot be told to halt: {}; it stops by itself after {:.0f} ms of silence",
            failures.empty() ? "" : "; ", name(requests[k].joint), done[k].error,
            joint.settings.command_timeout_s * 1e3);
      }
    }
    requests = failed;
  }
  return failures;
}

void TicDrives::start_homing(int joint_index, HomeDirection direction) {
  const std::lock_guard lock(mutex_);
  const auto i = static_cast<std::size_t>(joint_index);
  Joint& joint = joints_.at(i);
  const bool forward = direction == HomeDirection::kForward;
  const auto pins =
      perform({{i, Command::kGetSettings,
                at_offset(forward ? tic::kForwardLimitPins : tic::kReverseLimitPins), 1}},
              transfer_timeout_s_);
  if (!pins[0].error.empty()) throw DriveError(name(i) + ": " + pins[0].error);
  if (pins[0].data[0] == 0)
    throw DriveError({fmt::format("{} has no pin for its {} limit switch", name(i),
                                  forward ? "forward" : "reverse"),
                      "set one in Pololu's Tic Control Center", "", Cause::kMissing});
  joint.may_move = true;
  require({{i, Command::kGoHome, forward ? 1U : 0U}}, "look for its home switch");
  if (!read_until([&] { return joint.in_touch() && joint.last->homing(); }))
    throw DriveError(name(i) + " does not begin to look for its home switch");
}

void TicDrives::set_position(int joint_index, std::int32_t position_pulses) {
  const std::lock_guard lock(mutex_);
  const auto i = static_cast<std::size_t>(joint_index);
  read_status();
  if (joints_.at(i).may_move)
    throw DriveError(name(i) + " moves; it can be told where it stands only at rest");
  require({{i, Command::kHaltAndSetPosition, static_cast<std::uint32_t>(position_pulses)}},
          "take its position");
}

void TicDrives::reconnect() {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < 3; ++i)
    if (!joints_[i].in_touch()) open(i);
}

void TicDrives::feed_those_at_rest() {
  std::unique_lock lock(mutex_);
  const std::chrono::duration<double> period(feed_period_s_);
  while (!wake_.wait_for(lock, period, [this] { return ending_; })) {
    std::vector<Request> requests;
    for (std::size_t i = 0; i < 3; ++i)
      if (joints_[i].in_touch() && !joints_[i].may_move)
        requests.push_back({i, Command::kResetCommandTimeout});
    perform(requests, transfer_timeout_s_);
  }
}

/// Leaves every drive that knows its position holding it. The command timeout would end a Tic's
/// normal state and make its position uncertain, so each one is first put into safe start and then
/// told its position again.
void TicDrives::park() {
  halt_what_moves();
  read_status();
  std::vector<Request> leave, keep;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!joints_[i].ready() || joints_[i].may_move || !joints_[i].last->position_certain())
      continue;
    leave.push_back({i, Command::kEnterSafeStart});
    keep.push_back(
        {i, Command::kHaltAndSetPosition, static_cast<std::uint32_t>(joints_[i].last->position())});
  }
  perform(leave, transfer_timeout_s_);
  const bool all_left = read_until([&] {
    return std::none_of(keep.begin(), keep.end(),
                        [this](const Request& request) { return joints_[request.joint].ready(); });
  });
  if (all_left) perform(keep, transfer_timeout_s_);
}

}  // namespace planar
