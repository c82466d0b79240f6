#pragma once

#include <termios.h>

#include <optional>
#include <string>

namespace planar {

/// Turns keys into the commands of a JogConsole. One step of 0.1, 1 or 10 serves all motions, in mm
/// or degrees.
class JogKeys {
 public:
  /// Returns the command of a key as a terminal sends it ("q", "\x1b[A"). Empty for a key that has
  /// no command.
  std::optional<std::string> command(const std::string& key) const;

  /// Changes the step by "+" or "-". Returns whether it was one of these keys.
  bool change_step(const std::string& key);

  /// Says what the keys do, and the present step.
  std::string help() const;
  /// Says how long a step is.
  std::string step() const;

 private:
  int step_{1};  ///< index in the list of steps
};

/// Reads the terminal on standard input key by key and without echo. The destructor restores the
/// terminal.
class RawTerminal {
 public:
  /// Returns true when standard input is a terminal.
  static bool is_there();

  /// Sets the terminal up. Throws WorkError when standard input is no terminal.
  RawTerminal();
  ~RawTerminal();
  RawTerminal(const RawTerminal&) = delete;
  RawTerminal& operator=(const RawTerminal&) = delete;

  /// Waits for a key and returns its characters; an arrow sends three. Empty at the end of input.
  std::optional<std::string> key();

  /// Returns true when keys other than this one were pressed meanwhile. It does not wait. It
  /// forgets those keys, and the repetitions that a key sends while it is held down.
  bool other_key_than(const std::string& key);

  /// Forgets keys that were pressed meanwhile, such as those of a key held down during a motion.
  void forget_keys();

 private:
  std::optional<char> character();

  termios usual_{};
};

}  // namespace planar
