#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace planar {

/// Edits a command key by key: Tab completes it, up and down recall those entered before.
class CommandLine {
 public:
  enum class State { kOpen, kEntered, kLeft };
  /// Returns the lines that one which begins like this can become.
  using Completions = std::function<std::vector<std::string>(const std::string& begun)>;

  explicit CommandLine(Completions completions) : completions_(std::move(completions)) {}

  /// Begins an empty line.
  void begin();
  /// Takes a key as a terminal sends it. Enter ends the line, Esc leaves it.
  State take(const std::string& key);

  const std::string& text() const { return text_; }
  /// Returns what the line may become, where the key before was a Tab that left it open.
  const std::vector<std::string>& choices() const { return choices_; }

 private:
  void complete();
  void erase_last();
  void recall(std::ptrdiff_t step);

  Completions completions_;
  std::string text_;
  std::vector<std::string> choices_, entered_;
  std::size_t recalled_{0};  ///< in entered_; its size stands for the new line
};

}  // namespace planar
