#pragma once

#include <termios.h>

#include <optional>
#include <string>

namespace planar {

/// The terminal on standard input, key by key and without echo while this lives; as before after.
class RawTerminal {
 public:
  static bool is_there();

  /// Throws WorkError when standard input is no terminal.
  RawTerminal();
  ~RawTerminal();
  RawTerminal(const RawTerminal&) = delete;
  RawTerminal& operator=(const RawTerminal&) = delete;

  /// Waits for a key, of which an arrow sends three characters; empty at the end of input.
  std::optional<std::string> key();

  /// A line, echoed and edited as usual; empty at the end of input.
  std::optional<std::string> line();

  /// Whether keys other than this one were pressed meanwhile; forgets them and repetitions of it,
  /// which a key that is held down sends. Does not wait.
  bool other_key_than(const std::string& key);

  /// Forgets keys that were pressed meanwhile, such as those of a key held down during a motion.
  void forget_keys();

 private:
  std::optional<char> character();

  termios usual_{};
  termios raw_{};
};

}  // namespace planar
