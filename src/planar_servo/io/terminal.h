#pragma once

#include <unistd.h>

#include <string>

#include "planar_servo/core/operator.h"
#include "planar_servo/io/status_line.h"

namespace planar {

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
