#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace planar {

/// A serial port that carries lines of text. No other program that asks for the port's lock can use
/// it at the same time.
class SerialLine {
 public:
  /// Opens the port at a speed that is among bauds(). Throws WorkError with the remedy when that
  /// fails.
  SerialLine(const std::string& port, int baud);
  ~SerialLine();
  SerialLine(const SerialLine&) = delete;
  SerialLine& operator=(const SerialLine&) = delete;

  /// Returns the speeds that a port can have, bits per second.
  static std::vector<int> bauds();

  /// Sends all bytes. Throws WorkError when the line is closed or takes nothing.
  void write(std::string_view bytes);

  /// Returns the next line without its end, as soon as it has come. Empty when none has come within
  /// the time; with a time of 0, lines that have come already are returned. A line that never ends
  /// is cut. Throws WorkError when the line is closed.
  std::optional<std::string> read(double timeout_s);

 private:
  bool wait_for(short events, double timeout_s) const;
  std::optional<std::string> take_line();

  int descriptor_{-1};
  std::string received_;
};

}  // namespace planar
