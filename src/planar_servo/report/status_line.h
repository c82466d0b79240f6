#pragma once

#include <string>

namespace planar {

/// One line on standard error that is rewritten in place, on a terminal and unless the log is
/// quiet; otherwise nothing is written. It is wiped away at the end.
class StatusLine {
 public:
  StatusLine();
  ~StatusLine() { wipe(); }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  bool is_shown() const { return shown_; }
  /// Writes as much of the text as the terminal is wide. What others write goes over it.
  void show(const std::string& text);
  /// Makes room for a message that stays.
  void wipe();

 private:
  bool shown_;
  bool drawn_{false};
};

}  // namespace planar
