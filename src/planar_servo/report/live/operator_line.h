#pragma once

#include <unistd.h>

#include <string>

#include "planar_servo/report/status_line.h"

namespace planar {

/// The way between a program and who stands at the machine: messages and a status line on standard
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
  /// What a script sends is left to whom it is for.
  bool entered();
  /// Returns whether somebody at a terminal can press Enter.
  bool is_attended() const { return isatty(in_) != 0; }

 private:
  int in_;
  bool ended_{false};  ///< nothing more comes from `in`
  StatusLine line_;
};

}  // namespace planar
