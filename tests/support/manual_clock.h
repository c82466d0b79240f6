#pragma once

#include "planar_servo/base/core/clock.h"

namespace planar::test {

/// A clock whose time passes only by sleeping.
class ManualClock final : public Clock {
 public:
  double now_s() const override { return now_s_; }
  void sleep_for_s(double duration_s) override { now_s_ += duration_s; }

 private:
  double now_s_{0.0};
};

}  // namespace planar::test
