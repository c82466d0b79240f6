#pragma once

#include <optional>
#include <string>

namespace planar {

/// Reads lines from a pipe or a socket as they come. Lines end with CR, LF or both; empty ones are
/// passed over. A signal does not end a wait.
class LineReader {
 public:
  /// The descriptor must stay open as long as this lives.
  explicit LineReader(int descriptor) : descriptor_(descriptor) {}

  /// Returns the next line as soon as it has come; empty when none comes within the time, when
  /// ended(), and when is_endless().
  std::optional<std::string> next(double patience_s);

  /// Returns whether anything has come that next() has not returned.
  bool has_more();
  /// Returns whether the other side has closed.
  bool ended() const { return ended_; }
  /// Returns whether more has come than any line has.
  bool is_endless() const;

 private:
  bool hear(double patience_s);

  int descriptor_;
  std::string heard_;
  bool ended_{false};
};

}  // namespace planar
