#pragma once

#include <Eigen/Core>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/threads.h"

namespace planar {

/// A serial port of this machine whose other end is held here. It has a name of its own that
/// outlasts the line, as the names under /dev/serial/by-id do.
class PtyPort {
 public:
  /// `name` is where to put the link to the port; an earlier link is replaced. Throws InputError
  /// when that is impossible or a file is there.
  explicit PtyPort(std::filesystem::path name) : name_(std::move(name)) { plug_in(); }
  ~PtyPort() { unplug(); }
  PtyPort(const PtyPort&) = delete;
  PtyPort& operator=(const PtyPort&) = delete;

  std::string name() const { return name_.string(); }
  /// Returns what has come within the time; empty when nothing has, or the line is closed.
  std::string read(double timeout_s);
  void write(std::string_view bytes);
  /// Returns this side's descriptors, for a program that is to speak on the line.
  int inner() const { return inner_; }
  int outer() const { return outer_; }

  /// Ends the line, as by unplugging, and plugs in another one.
  void unplug();
  void plug_in();

 private:
  std::filesystem::path name_, device_;  ///< the link, and where it leads
  int inner_{-1}, outer_{-1};
};

/// A Grbl 1.1 board on a serial port of its own, with motors that turn in real time. It has the
/// jogging, jog cancel, hold, alarms, limit inputs, homing and settings of Grbl's documentation;
/// the driver's protocol code is not used. Motion along straight pieces is planned to rest at the
/// end of what is queued, and at sharp corners. Safe to use from any thread.
class EmulatedGrbl {
 public:
  using Pulses = Eigen::Vector3i;
  using Settings = std::map<int, double>;

  /// Is called with the shafts, in pulses, whenever they have turned.
  using OnPosition = std::function<void(const Pulses& shafts)>;

  /// `port` is the name of the serial port, as PtyPort has it. Settings that are not given are
  /// Grbl's own.
  EmulatedGrbl(std::filesystem::path port, const Settings& settings, OnPosition on_position = {});

  /// Returns a setting of each axis, Grbl's own where none is given.
  static Eigen::Vector3d of_axes(const Settings& settings, int first);

  std::string port() const { return port_.name(); }
  /// Throws what has ended the board's thread.
  void require_well() const { server_->require_well(); }
  /// Places the switch of each axis, its shaft's millimetres. Without them a search fails.
  void place_switches(const std::optional<Eigen::Vector3d>& at_mm);

 protected:
  /// For boards with injected faults; `mutex_` guards all of it.
  using Lock = std::lock_guard<std::mutex>;
  /// Lets the motors turn until now.
  void advance();
  void hear(char byte);
  void alarm(int number);
  /// Restarts as after a power cut: the motors stop abruptly, and where they stand is 0.
  void begin_anew();
  double setting(int number) const { return settings_.at(number); }

  std::mutex mutex_;
  PtyPort port_;
  Settings settings_;
  Pulses told_{0, 0, 0};       ///< what the motors have really turned
  double last_cancel_s_{0.0};  ///< when it last began to brake for a jog cancel
  std::string last_jog_;       ///< the last that it was sent, whether it obeyed or not
  std::string pins_;           ///< axes whose limit inputs are pressed
  bool silent_{false};         ///< it neither obeys nor answers
  int answers_to_lose_{0};     ///< this many of the next answers to lines are not sent
  std::string banner_{"\r\nGrbl 1.1h ['$' for help]\r\n"};
  /// Answers lines first, as other firmware does; empty for those that Grbl answers alike.
  std::function<std::optional<std::string>(const std::string& line)> other_answer_;

 private:
  enum class State { kIdle, kJog, kHold, kHome, kAlarm };
  struct Piece {
    Eigen::Vector3d target_mm;
    double feed_mm_s;
  };

  void serve();
  void obey_line(const std::string& line);
  std::string answer_to(const std::string& line);
  std::string jog(const std::string& words);
  std::string change(const std::string& words);
  std::string list_settings() const;
  std::string report() const;
  void write(const std::string& text);
  void step(double dt_s);
  void step_jog(double dt_s);
  void step_home(double dt_s);
  double way_to_rest() const;
  void reset();
  void stop_abruptly();
  void tell_position();
  Eigen::Vector3d of_axes(int first) const { return of_axes(settings_, first); }
  Pulses pulses(const Eigen::Vector3d& mm) const;

  SteadyClock clock_;
  OnPosition on_position_;
  State state_{State::kIdle};
  bool cancelling_{false};
  std::string line_;
  std::vector<std::string> held_lines_;
  std::deque<Piece> queue_;
  Eigen::Vector3d counted_mm_{0.0, 0.0, 0.0};
  Eigen::Vector3d offset_mm_{0.0, 0.0, 0.0};  ///< the shafts' lengths minus the counted ones
  std::optional<Eigen::Vector3d> switches_mm_;
  double speed_{0.0};  ///< mm/s along the way
  double now_s_;
  std::optional<Repeater> server_;
};

}  // namespace planar
