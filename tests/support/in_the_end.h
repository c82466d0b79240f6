#pragma once

#include "planar_servo/base/core/clock.h"

namespace planar::test {

// Aravis needs 2.5 s to see that nobody answers and 5 s to close what is dead, and tries again.
constexpr double kRecovery_s = 60.0;

/// Returns true when `holds` becomes true within the time that a camera needs to recover.
template <typename Condition>
bool in_the_end(const Condition& holds) {
  SteadyClock clock;
  const double deadline_s = clock.now_s() + kRecovery_s;
  while (!holds()) {
    if (clock.now_s() > deadline_s) return false;
    clock.sleep_for_s(0.002);
  }
  return true;
}

}  // namespace planar::test
