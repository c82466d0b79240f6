#pragma once

#include <optional>
#include <string>

namespace planar {

/// Turns keys into the commands of a JogConsole. One step serves all motions: 0.1, 1 or 10 mm or
/// degrees.
class JogKeys {
 public:
  /// The command of a key as a terminal sends it ("q", "\x1b[A"); empty when it has none.
  std::optional<std::string> command(const std::string& key);

  /// What the keys do, and the step at present.
  std::string help() const;

 private:
  int step_{1};  ///< of the list of steps
};

}  // namespace planar
