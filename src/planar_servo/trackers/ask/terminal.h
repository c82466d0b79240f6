#pragma once

#include <string>

#include <unistd.h>

namespace planar {

/// Somebody who answers questions. By default it is who sits at the terminal of this program.
class Terminal {
 public:
  /// Asks on `out` and hears on `in`, both descriptors of open files, which stay open.
  explicit Terminal(int in = STDIN_FILENO, int out = STDERR_FILENO) : in_(in), out_(out) {}

  /// Returns the answered line without its end and without blanks around it. Throws WorkError when
  /// nobody can answer: standard input is closed or at its end, or the program was interrupted.
  std::string ask(const std::string& question) const;

  /// Returns whether somebody sits at a terminal, and not a script.
  bool is_attended() const { return isatty(in_) != 0; }

 private:
  int in_;
  int out_;
};

}  // namespace planar
