#pragma once

#include <unistd.h>

#include <cstddef>
#include <string>

#include "planar_servo/core/clock.h"

namespace planar {

/// One line on standard error, or a few, rewritten in place on a terminal, unless the log is quiet;
/// otherwise nothing is written. It is wiped away at the end.
class StatusLine {
 public:
  StatusLine();
  ~StatusLine() { wipe(); }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  bool is_shown() const { return shown_; }
  /// Writes as much of each line as the terminal is wide. What others write goes over it.
  void show(const std::string& text);
  /// Makes room for a message that stays.
  void wipe();

 private:
  bool shown_;
  bool drawn_{false};
};

/// The link between a program and the person at the machine: messages and a status line on standard
/// error, and the Enter key.
class OperatorLine {
 public:
  /// `in` is where Enter comes from, a descriptor of an open file, which stays open.
  explicit OperatorLine(int in = STDIN_FILENO) : in_(in) {}

  /// Shows what is the case now; on a terminal only.
  void show(const std::string& status) { line_.show(status); }
  /// Writes a message that stays.
  void say(const std::string& message);
  /// Writes a message that stays, as a warning.
  void warn(const std::string& message);

  /// Returns whether Enter was pressed at a terminal since this was asked last. It does not wait.
  /// Input from a script is left unread.
  bool entered();
  /// Returns whether somebody at a terminal can press Enter.
  bool is_attended() const { return isatty(in_) != 0; }

 private:
  int in_;
  bool ended_{false};  ///< nothing more comes from `in`
  StatusLine line_;
};

/// A progress bar on standard error. It appears when that is a terminal, the log is not quiet and
/// the work has taken a second; it is wiped away at the end.
class ProgressBar {
 public:
  explicit ProgressBar(std::string label = {});

  void show(std::size_t done, std::size_t all);
  /// Shows a phase of work, as a `Progress` reports it.
  void show(const std::string& phase, double share);

 private:
  void draw(const std::string& label, double share, const std::string& figure);

  std::string label_;
  StatusLine line_;
  SteadyClock clock_;
  double draw_after_s_;
};

}  // namespace planar
