#pragma once

#include "planar_servo/core/clock.h"

namespace planar {

/// Time that passes only when somebody waits.
class VirtualClock final : public Clock {
 public:
  double now_s() const override { return now_s_; }
  /// Throws std::invalid_argument for a negative or non-finite duration.
  void sleep_for_s(double duration_s) override;
  /// To a time that is not before now.
  void advance_to(double t_s) { sleep_for_s(t_s - now_s_); }

 private:
  double now_s_{0.0};
};

}  // namespace planar
