#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/hardware/drives/grbl_board.h"
#include "planar_servo/hardware/drives/grbl_protocol.h"

namespace planar {

/// Positions of a board's axes X, Y, Z, pulses.
using AxisPulses = Eigen::Vector3i;

/// The limits of one axis of a board, in its lengths.
struct AxisLimits {
  double pulses_per_mm{250.0};
  double speed_mm_s{0.0};
  double acceleration_mm_s2{0.0};
};

/// Returns how far beyond a position that is passed at `speed` a motion may be queued so that, left
/// alone, it ends at rest within `duration`. It speeds up to `top_speed` at most. One set of units.
double reach(double speed, double top_speed, double acceleration, double duration);

/// A straight way of a board's axes, handed out in short pieces as it is travelled, so that the
/// board never has more in its queue than it travels in grbl::kLongestRun_s.
class JogPath {
 public:
  JogPath(const AxisPulses& from, const AxisPulses& to, const std::array<AxisLimits, 3>& limits);

  /// Returns the end of the next piece for axes that are here. Empty while enough, or all, is sent.
  std::optional<AxisPulses> next_piece(const AxisPulses& here);

  /// Returns the end of the last piece that was handed out.
  const AxisPulses& sent() const { return sent_; }
  bool all_sent() const { return sent_ == to_; }
  double speed_mm_s() const { return speed_; }
  /// Returns whether a target can be reached from here, by the end of the last piece, without any
  /// axis turning back.
  bool leads_to(const AxisPulses& target, const AxisPulses& here) const;

 private:
  Eigen::Vector3d in_mm(const AxisPulses& pulses) const;

  AxisPulses from_, to_, sent_;
  Eigen::Vector3d pulses_per_mm_;
  Eigen::Vector3d direction_{0.0, 0.0, 0.0};
  double length_{0.0}, speed_{0.0}, acceleration_{0.0};  // mm and seconds
  double sent_length_{0.0};
};

/// Filters a board's reports. Grbl's lines have no checksum, so a single report may be garbled: a
/// position off the way, or an input that is pressed or released, is accepted when the next report
/// agrees. The way is a box of all positions where the axes may be.
class GrblWatch {
 public:
  explicit GrblWatch(const Eigen::Vector3d& pulses_per_mm) : pulses_per_mm_(pulses_per_mm) {}

  void take(const grbl::Report& report);
  /// Returns whether garbage must end a move; garbled reports do when there are several in a row.
  bool minds(const grbl::Garbage& garbage);

  grbl::State state() const { return report_.state; }
  bool turns() const { return report_.turns; }
  /// Returns the letters of the inputs that are on, by the last report.
  const std::string& inputs_on() const { return report_.pins; }
  /// Returns whether the axes turn, have slowed down and have not sped up since.
  bool slows() const { return slows_; }
  /// Returns whether the board has said where it is.
  bool knows_place() const { return knows_place_; }
  const AxisPulses& here() const { return here_; }
  /// Returns false when the axes are off their way, if there is one.
  bool on_way() const { return way_.isEmpty() || on_way(here_); }
  /// Returns whether the last report was of a place on the way.
  bool settled() const { return !off_way_seen_; }
  /// Says where the axes are instead of on their way.
  std::string off_way_words() const;

  void extend_way(const AxisPulses& place) { way_.extend(place); }
  /// The axes rest where they are.
  void end_way() { way_ = Eigen::AlignedBox3i(here_); }
  /// The next position that is reported is accepted.
  void forget_way();

  /// A move begins: inputs that are pressed now do not count until they have been released.
  void begin_move() { pressed_from_start_ = pressed_ + report_.pins; }
  /// Returns whether the input of an axis 'X' to 'Z' was pressed since then.
  bool newly_pressed(char axis) const;

 private:
  void take_pins(const std::string& previous);
  void take_place(const std::array<double, 3>& position_mm);
  bool on_way(const AxisPulses& place) const;

  Eigen::Vector3d pulses_per_mm_;
  grbl::Report report_;
  AxisPulses here_{0, 0, 0};
  bool knows_place_{false}, off_way_seen_{false}, slows_{false};
  Eigen::AlignedBox3i way_;
  std::string pressed_, pressed_from_start_;  ///< letters of axes
  int garbled_reports_{0};
};

/// The axes X, Y, Z of a board, in pulses of its own count. They go straight to a target, and
/// together. poll() hands a move to the board in pieces, never more than it travels in
/// grbl::kLongestRun_s, so that it stops when its caller does.
///
/// Anything unexpected from the board ends the move: the board brakes to rest, and faults() says
/// why until it is unlocked. All methods but the queries throw WorkError when it is out of touch.
class GrblAxes {
 public:
  /// Opens and resets the board. Throws WorkError with the remedy when it cannot be used.
  explicit GrblAxes(const GrblSettings& settings);
  /// Brakes; ends a search abruptly.
  ~GrblAxes();
  GrblAxes(const GrblAxes&) = delete;
  GrblAxes& operator=(const GrblAxes&) = delete;

  /// Reads and judges the board's lines, and sends the next pieces.
  void poll();
  /// Ends a hold, or by a reset the lock after an alarm. Clears the faults.
  void unlock();
  /// During a move the axes continue from the end of what is queued if the target lies beyond it,
  /// and otherwise brake first.
  void go_to(const AxisPulses& target, const std::array<AxisLimits, 3>& limits);
  /// Has the board search for the switches of all axes at once.
  void search_switches();
  /// Brakes to rest and waits for it; the position stays certain. A search ends abruptly.
  void halt();

  const AxisPulses& here() const { return watch_.here(); }
  AxisPulses target() const { return goal_.value_or(here()); }
  bool moving() const { return may_move_; }
  bool searching() const { return searching_; }
  /// Returns whether the last search has found the switches; the axes stand at them.
  bool found_switches() const { return found_switches_; }
  /// Returns whether the board takes moves: it was unlocked and no alarm or reset came since.
  bool unlocked() const { return unlocked_; }
  /// Returns the board's state as a fault, in words. Empty when it can take moves.
  std::string state_words() const { return grbl::state_words(watch_.state()); }
  /// Returns whether a person or a safety circuit may have stopped it since it was unlocked.
  bool stopped_by_hand() const;
  /// Returns how often the axes' position was lost.
  int losses() const { return losses_; }
  /// Returns what is wrong with an axis, 0 for X to 2 for Z.
  const std::vector<std::string>& faults(std::size_t axis) const { return faults_.at(axis); }

 private:
  bool hear_report(double patience_s);
  void take(const grbl::Line& line);
  void take_report(const grbl::Report& report);
  void judge();
  bool reads_no_longer();
  void follow();
  bool has_ended();
  void feed();
  void end_search();
  /// Polls until the condition holds; returns false when it does not in time.
  template <typename Condition>
  bool poll_until(const Condition& holds, double patience_s);

  void begin_path(const AxisPulses& from);
  void brake();
  void brake_for(const std::string& words);
  void stop_by_hand(const std::string& words);
  void note_fault(const std::string& words);
  void lose_state();
  void lose_place();
  void reset();

  SteadyClock clock_;
  Eigen::Vector3d pulses_per_mm_;
  GrblWatch watch_;
  GrblBoard board_;
  std::array<std::vector<std::string>, 3> faults_;
  int losses_{0};
  bool stopped_by_hand_{false};  ///< since it was unlocked
  bool alarmed_{false};          ///< since it was unlocked; a board restarts after a failed search
  bool unlocked_{false}, may_move_{false}, braking_{false};
  bool searching_{false}, found_switches_{false};
  bool stopped_seen_{false};  ///< by the last report
  double silent_s_{0.0};      ///< in which polls have waited for a report in vain, up to now
  double sent_s_{0.0};        ///< when the last move was sent
  int unread_reports_{0};     ///< in a row, in which the board slows down and leaves a piece unread
  double unread_since_s_{0.0};
  std::optional<AxisPulses> goal_;
  std::array<AxisLimits, 3> limits_;
  std::optional<JogPath> path_;
};

}  // namespace planar
