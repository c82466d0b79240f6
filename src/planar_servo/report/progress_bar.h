#pragma once

#include <cstddef>
#include <string>

#include "planar_servo/core/clock.h"

namespace planar {

/// A progress bar on standard error. It appears when that is a terminal, the log is not quiet and
/// the work has taken a second; it is wiped away at the end.
class ProgressBar {
 public:
  explicit ProgressBar(std::string label = {});
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(std::size_t done, std::size_t all);
  /// Shows a phase of work, as a `Progress` reports it.
  void show(const std::string& phase, double share);

 private:
  void draw(const std::string& label, double share, const std::string& figure);

  std::string label_;
  bool wanted_;
  SteadyClock clock_;
  double draw_after_s_;
  std::size_t drawn_{0};  ///< characters on the terminal now
};

}  // namespace planar
