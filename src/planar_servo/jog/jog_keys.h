#pragma once

#include <optional>
#include <string>

namespace planar {

/// Turns keys into the commands of a JogConsole. One step of 0.1, 1 or 10 serves all motions, in mm
/// or degrees.
class JogKeys {
 public:
  /// Returns the command of a key as a terminal sends it ("q", "\x1b[A"). Empty for a key that has
  /// no command.
  std::optional<std::string> command(const std::string& key);

  /// Says what the keys do, and the present step.
  std::string help() const;

 private:
  int step_{1};  ///< index in the list of steps
};

}  // namespace planar
