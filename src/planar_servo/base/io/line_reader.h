#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace planar {

/// Reads lines from a pipe, a socket or a serial port as they come. Lines end with CR, LF or both;
/// empty ones are passed over. A signal does not end a wait.
class LineReader {
 public:
  /// A line that has no end within so many characters is cut behind what has come of it.
  static constexpr std::size_t kLongest = 1000;

  /// The descriptor must stay open as long as this lives.
  explicit LineReader(int descriptor) : descriptor_(descriptor) {}

  /// Returns the next line as soon as it has come; empty when none comes within the time, and when
  /// ended().
  std::optional<std::string> next(double patience_s);

  /// Returns whether anything has come that next() has not returned.
  bool has_more();
  /// Returns whether the other side has closed.
  bool ended() const { return ended_; }

 private:
  bool hear(double patience_s);

  int descriptor_;
  std::string heard_;
  bool ended_{false};
};

}  // namespace planar
