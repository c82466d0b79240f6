#pragma once

#include <cmath>
#include <stdexcept>

#include "planar_servo/core/clock.h"

namespace planar {

/// A clock whose time passes only when somebody waits.
class VirtualClock final : public Clock {
 public:
  double now_s() const override { return now_s_; }
  /// Throws std::invalid_argument for a duration that is negative or not finite.
  void sleep_for_s(double duration_s) override {
    if (!std::isfinite(duration_s) || duration_s < 0.0)
      throw std::invalid_argument("a duration to wait must be finite and not negative");
    now_s_ += duration_s;
  }
  /// Waits until a time that is not before now.
  void advance_to(double t_s) { sleep_for_s(t_s - now_s_); }

 private:
  double now_s_{0.0};
};

}  // namespace planar
