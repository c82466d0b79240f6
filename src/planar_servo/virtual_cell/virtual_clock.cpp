#include "planar_servo/virtual_cell/virtual_clock.h"

#include <cmath>
#include <stdexcept>

namespace planar {

void VirtualClock::sleep_for_s(double duration_s) {
  if (!std::isfinite(duration_s) || duration_s < 0.0)
    throw std::invalid_argument("a duration to wait must be finite and not negative");
  now_s_ += duration_s;
}

}  // namespace planar
