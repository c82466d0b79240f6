#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/hardware/drives/tic_bus.h"

namespace planar {

struct TicSettings {
  std::string serial;
  /// A drive that receives nothing for this long stops by itself. A transfer may take half of it.
  double command_timeout_s{0.25};
};

/// Drives three Pololu Tics on USB, told apart by their serial numbers. Opening a drive sets its
/// command timeout, with halt and hold as the response, and reads both back. It refuses what could
/// make it move wrongly: another control mode, disabled safe start, firmware that cannot home.
///
/// The command timeout is always on. While a drive moves, only status() resets it, so the drive
/// stops when its caller does; at rest a thread of this class resets it.
///
/// The destructor halts what moves and leaves each drive that knows its position holding that
/// position, so the next program need not home it.
class TicDrives final : public DriveGroup {
 public:
  /// Opens the drives; switches nothing on and moves nothing. Throws DriveError naming every drive
  /// that cannot be used, with the remedy, and std::invalid_argument when two joints share one.
  explicit TicDrives(const std::array<TicSettings, 3>& settings);
  ~TicDrives() override;
  TicDrives(const TicDrives&) = delete;
  TicDrives& operator=(const TicDrives&) = delete;

  /// Switches all drives on, unless one is out of touch, and forgets what stopped them by hand. A
  /// drive that was stopped does not resume its old move. Throws DriveError for a drive out of
  /// touch; the status of a drive that does not switch on says why.
  void energize() override;
  /// Throws InputError for limits that no Tic can keep, and DriveError when one does not take them.
  void set_limits(const std::array<DriveLimits, 3>& limits) override;
  void set_targets(const std::array<std::int32_t, 3>& targets_pulses) override;
  void halt() override;
  void forget_positions() override;
  std::array<DriveStatus, 3> status() override;
  /// Throws DriveError when the drive has no pin for the switch or does not begin.
  void start_homing(int joint, HomeDirection direction) override;
  void set_position(int joint, std::int32_t position_pulses) override;
  void reconnect() override;

 private:
  struct Joint {
    TicSettings settings;
    std::unique_ptr<TicPort> port;
    Refusal error{};  ///< why its last transfer failed; it is out of touch then
    std::optional<tic::StatusBlock> last{};
    std::optional<std::int32_t> goal{};  ///< its target, until it has been seen there
    bool may_move{true};

    bool in_touch() const { return port != nullptr && error.fault.empty(); }
    bool ready() const { return in_touch() && last && last->ready(); }
  };
  struct Request {
    std::size_t joint;
    tic::Command command;
    std::uint32_t value{0};  ///< as in TicTransfer
    std::size_t bytes{0};    ///< to be read
  };

  void open(std::size_t joint);
  /// Applies the settings that may be set. Throws WorkError that says what is wrong with the others
  /// or the firmware.
  void configure(std::size_t joint);
  void set_timeout(std::size_t joint, const std::vector<std::uint8_t>& settings);
  /// Runs all requests at once and notes failures in each joint's `error`; without a port, that is
  /// the failure.
  std::vector<TicTransfer> perform(const std::vector<Request>& requests, double timeout_s);
  /// Runs all requests of setup; throws WorkError with the reason when one fails.
  std::vector<TicTransfer> set_up(const std::vector<Request>& requests);
  /// Runs all requests; throws DriveError that names `what` was to be done when one fails.
  void require(const std::vector<Request>& requests, const std::string& what);
  void read_status(tic::Command read = tic::Command::kGetVariables);
  void take_status(Joint& joint, const TicTransfer& transfer);
  /// Polls until the condition holds; returns false when it does not in time.
  template <typename Condition>
  bool read_until(const Condition& holds);
  /// Halts every drive that may move. Returns what could not be halted, in words.
  std::string halt_what_moves();
  void feed_those_at_rest();
  void park();
  std::string name(std::size_t joint) const;

  TicBus bus_;
  std::array<Joint, 3> joints_;
  double transfer_timeout_s_{0.0};
  double feed_period_s_{0.0};
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_{false};
  std::thread feeder_;
};

}  // namespace planar
