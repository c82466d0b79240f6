#pragma once

#include <cstddef>
#include <string>

#include "planar_servo/core/clock.h"

namespace planar {

/// A progress bar on the terminal: drawn on standard error when that is a terminal and the log is
/// not quiet, once the work has taken a second; wiped away at its end.
class ProgressBar {
 public:
  explicit ProgressBar(std::string label = {});
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(std::size_t done, std::size_t all);
  /// As `Progress`.
  void show(const std::string& phase, double share);

 private:
  void draw(const std::string& label, double share, const std::string& figure);

  std::string label_;
  bool wanted_;
  SteadyClock clock_;
  double draw_after_s_;
  std::size_t drawn_{0};  ///< characters
};

}  // namespace planar
