#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planar_servo/base/io/line_reader.h"
#include "planar_servo/hardware/drives/grbl_protocol.h"

namespace planar {

/// Says why a serial port was not opened, by `errno`, and what mends that.
Refusal why_not_opened(const std::string& port);

/// Keeps other programs from a port that is open as `descriptor`. Returns which have it already, as
/// far as this user may see, if any do.
std::optional<Refusal> claim(int descriptor, const std::string& port);

/// A serial port that carries lines of text. It is refused while another program has it open, and
/// kept from others where the system can do that.
class SerialLine {
 public:
  /// Opens the port at one of the bauds(). Throws WorkError with the remedy when that fails.
  SerialLine(const std::string& port, int baud);
  ~SerialLine();
  SerialLine(const SerialLine&) = delete;
  SerialLine& operator=(const SerialLine&) = delete;

  /// Returns the speeds that a port can have, bits per second.
  static std::vector<int> bauds();

  /// Sends all bytes. Throws WorkError when the line is closed or takes nothing.
  void write(std::string_view bytes);

  /// Returns the next line as LineReader::next() does. Throws WorkError when the port is closed.
  std::optional<std::string> read(double timeout_s);

 private:
  int descriptor_;
  LineReader reader_;
};

/// A Grbl or grblHAL board on a serial port; keeps track of the lines that it has not answered yet.
class GrblBoard {
 public:
  /// Opens the port, resets the board, and reads its version and settings. Nothing moves. Throws
  /// WorkError with the remedy when there is no such board, or one with other firmware.
  GrblBoard(const std::string& port, int baud);

  const grbl::Banner& version() const { return version_; }
  const grbl::Settings& settings() const { return settings_; }

  // The following throw WorkError when the line is closed.

  /// Sends a byte that the board obeys at once.
  void tell(char byte);
  /// Sends a line, which the board accepts or rejects later.
  void send(const std::string& line);
  /// Returns the next line from the board. Empty when none comes within this time.
  std::optional<grbl::Line> hear(double timeout_s);
  /// Resets the board, which discards all orders. Throws WorkError when it does not come back.
  void reset();

  /// Returns the letters of the inputs that are on, in two reports in a row.
  std::string inputs_on();
  /// Says, after `lead`, who else has the port open; empty when nobody is known to.
  std::string sharers(const std::string& lead) const;

  std::size_t unanswered() const { return unanswered_.size(); }
  /// Stops waiting for answers, because some were lost on the line.
  void forget_unanswered() { unanswered_.clear(); }
  /// Returns the line that the board answered last.
  const std::string& answered() const { return answered_; }

 private:
  void find_board(int baud);
  bool boots() const;
  void read_settings();
  void read_paths();
  std::optional<grbl::Banner> hear_banner(double timeout_s, std::string& otherwise);

  SerialLine line_;
  std::string port_;
  std::string said_;  ///< until its settings came
  grbl::Banner version_;
  grbl::Settings settings_;
  std::deque<std::string> unanswered_;
  std::string answered_;
};

}  // namespace planar
