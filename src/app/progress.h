#pragma once

#include <cstddef>
#include <string>

namespace planar {

/// A progress bar on the terminal: drawn on standard error, and only when that is a terminal.
class ProgressBar {
 public:
  explicit ProgressBar(std::string label);
  void show(std::size_t done, std::size_t all) const;

 private:
  std::string label_;
  bool terminal_;
};

}  // namespace planar
