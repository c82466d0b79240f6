#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>

#include "planar_servo/drives/grbl/grbl_protocol.h"
#include "planar_servo/drives/grbl/serial_line.h"

namespace planar {

/// A Grbl or grblHAL board on a serial port: knows which lines it has not answered yet.
class GrblBoard {
 public:
  /// Opens the port, resets the board, and reads its version and settings. Nothing moves. Throws
  /// WorkError with the remedy when there is no such board.
  GrblBoard(const std::string& port, int baud);

  const grbl::Banner& version() const { return version_; }
  const grbl::Settings& settings() const { return settings_; }

  // The following throw WorkError when the line is closed.

  /// Sends a byte that the board obeys at once.
  void tell(char byte);
  /// Sends a line, which the board accepts or rejects later.
  void send(const std::string& line);
  /// Returns the next thing the board says. Empty when it says nothing for this time.
  std::optional<grbl::Line> hear(double timeout_s);
  /// Resets the board, which forgets what it was to do. Throws WorkError when it does not come
  /// back.
  void reset();

  std::size_t unanswered() const { return unanswered_.size(); }
  /// Waits for no more answers, because some were lost on the line.
  void forget_unanswered() { unanswered_.clear(); }
  /// Returns the line that the board answered last.
  const std::string& answered() const { return answered_; }

 private:
  void find_board(const std::string& port, int baud);
  void read_settings();
  std::optional<grbl::Banner> hear_banner(double timeout_s, std::string& otherwise);

  SerialLine line_;
  grbl::Banner version_;
  grbl::Settings settings_;
  std::deque<std::string> unanswered_;
  std::string answered_;
};

}  // namespace planar
