#pragma once

#include <unistd.h>

#include <cstddef>
#include <string>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/operator.h"

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

/// Who sits at the terminal of this program, or the script that writes its input. Messages are
/// those of the log.
class Terminal final : public Operator {
 public:
  /// Asks on `out` and hears on `in`, both descriptors of open files, which stay open.
  explicit Terminal(int in = STDIN_FILENO, int out = STDERR_FILENO) : in_(in), out_(out) {}

  bool is_attended() const override { return isatty(in_) != 0; }
  /// What was typed at a terminal before the question stood there is discarded; what a script sends
  /// is not. Nobody can answer where standard input is closed or at its end, and once the program
  /// was interrupted.
  std::string ask(const std::string& question) override;
  /// Input from a script is left unread.
  bool entered() override;
  /// On a terminal only.
  void show(const std::string& status) override { line_.show(status); }
  void say(const std::string& message) override;
  void warn(const std::string& message) override;

 private:
  int in_;
  int out_;
  bool ended_{false};  ///< nothing more comes from `in`
  StatusLine line_;
};

}  // namespace planar
