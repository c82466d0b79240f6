#pragma once

#include <cstddef>
#include <string>

#include "planar_servo/core/clock.h"

namespace planar {

/// One line on standard error, rewritten in place on a terminal, unless the log is quiet; otherwise
/// nothing is written. It is wiped away at the end.
class StatusLine {
 public:
  StatusLine();
  ~StatusLine() { wipe(); }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  bool is_shown() const { return shown_; }
  /// Writes as much as the terminal is wide. What others write goes over it.
  void show(const std::string& text);
  /// Makes room for a message that stays.
  void wipe();

 private:
  bool shown_;
  bool drawn_{false};
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
