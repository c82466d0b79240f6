#pragma once

#include <sys/types.h>

#include <array>
#include <chrono>
#include <limits>
#include <optional>
#include <string>

#include "planar_servo/base/io/line_reader.h"
#include "planar_servo/hardware/links/machine_link.h"

namespace planar {

/// By as much the joints of a machine with encoders may stand beside where they are sent.
constexpr int kInPosition_counts = 2;

/// One of LinuxCNC's joints, which turns in degrees as the motor behind its gear does.
struct LinuxcncJoint {
  char axis{'A'};
  int number{0};  ///< of the joint, as LinuxCNC counts
  bool has_switch{false};
  double counts_per_deg{1.0};  ///< a count is what the cell file calls a pulse
  DriveLimits rated;           ///< of the cell
};

/// Between which angles LinuxCNC moves a joint, counted from where LinuxCNC has homed it.
struct LinuxcncRoom {
  double least_deg{-std::numeric_limits<double>::infinity()};
  double most_deg{std::numeric_limits<double>::infinity()};
};

/// Where LinuxCNC's linuxcncrsh listens.
struct LinuxcncHost {
  std::string host{"127.0.0.1"};
  int port{5007};
  std::string password{"EMC"}, enable_password{"EMCTOO"};
  std::array<LinuxcncJoint, 3> joints;
};

/// A connection to linuxcncrsh, which is asked by lines.
class RshConnection {
 public:
  /// Connects and says hello. Throws WorkError with the remedy when nobody answers as linuxcncrsh.
  explicit RshConnection(const LinuxcncHost& host);
  ~RshConnection();
  RshConnection(const RshConnection&) = delete;
  RshConnection& operator=(const RshConnection&) = delete;

  void send(const std::string& line);
  /// Returns the next line as soon as it has come; empty when none comes in time.
  std::optional<std::string> hear(double patience_s);
  /// Returns the answer to a line. Throws WorkError when none comes in time.
  std::string ask(const std::string& line);
  /// Returns what follows the words that a get repeats.
  std::string get(const std::string& what);
  /// Returns whether that has this word.
  bool says(const std::string& what, const char* word) {
    return get(what).find(word) != std::string::npos;
  }
  int descriptor() const { return socket_; }

 private:
  int socket_{-1};
  std::optional<LineReader> reader_;
};

/// A process that has LinuxCNC brake when this one dies, or hangs while the machine moves. Without
/// it LinuxCNC would finish the move.
class DeadMansHandle {
 public:
  /// `stopper` is the connection by which it says `words`.
  DeadMansHandle(const RshConnection& stopper, const std::string& words);
  ~DeadMansHandle();
  DeadMansHandle(const DeadMansHandle&) = delete;
  DeadMansHandle& operator=(const DeadMansHandle&) = delete;

  /// Is called every few milliseconds while the machine moves, or else it brakes after kPatience_s.
  /// Returns false when the process has ended while it is needed.
  bool hold(bool moving);
  static constexpr double kPatience_s{0.15};

 private:
  pid_t process_{-1};
  int line_{-1};
  bool moving_{false};
};

/// Three joints of a machine that LinuxCNC moves, through linuxcncrsh, a move by one MDI line.
/// linuxcncrsh acknowledges a command 0.1 s after it has obeyed, and takes commands from one
/// connection at a time, the one that asked for it last: so one moves, one reads, and one stops.
class LinuxcncLink final : public MachineLink {
 public:
  /// Compares the machine's INI with the cell, where that is a file of this machine. Moves nothing.
  /// Throws WorkError when it cannot be used.
  explicit LinuxcncLink(const LinuxcncHost& host);

  /// Leaves the emergency stop that LinuxCNC itself has set, switches the machine on, and homes
  /// joints without a switch where they stand, unless they are; their counts are lost by that.
  void switch_on() override;
  void go_to(const Pulses& counts, const std::array<DriveLimits, 3>& limits) override;
  void stop() override;
  void search_home(int joint, HomeDirection direction) override;
  MachineState read() override;
  const char* starter() const override { return "LinuxCNC's messages, limits and feed override"; }

  /// Says what could not be compared with the cell; empty when all was.
  const std::string& unchecked() const { return unchecked_; }

 private:
  using Clock = std::chrono::steady_clock;

  void require_room(const Pulses& counts) const;
  void set(const std::string& what);
  void take_control();
  bool is_homed(int joint);
  void home(int joint);
  void home_in_place(int joint);
  void send_move();
  void hear_mover(double patience_s);
  void hold(bool moving);
  void check_control();
  void note_who_controls(const std::string& stranger);
  Pulses counts() const;
  MachineState state_now();

  LinuxcncHost host_;
  mutable RshConnection reader_;
  RshConnection mover_, stopper_;
  DeadMansHandle handle_;
  std::string unchecked_;
  std::array<LinuxcncRoom, 3> rooms_;
  std::optional<Pulses> target_;
  std::string move_;   ///< the line that leads there
  int sends_left_{0};  ///< of that line
  bool awaits_mover_{false};
  bool controls_{false};      ///< linuxcncrsh obeys mover_, as far as we know
  std::string refused_;       ///< by LinuxCNC, of the last move
  bool is_strangers_{false};  ///< another client has taken the control
  Pulses here_{0, 0, 0};
  bool rests_{true};  ///< the joints rest until they are told to move
  Clock::time_point changed_;
  std::optional<Clock::time_point> told_to_stop_;    ///< until it rests
  std::optional<Clock::time_point> stopping_since_;  ///< the first time of that
  bool stop_heard_{false};                           ///< of the last order to stop
  bool stopper_lags_{false};                         ///< it may not have obeyed them all yet
  int losses_{0};
  bool was_switched_on_{false};  ///< by this program
  bool was_on_{false};
  std::optional<int> homing_joint_;
};

}  // namespace planar
