#include "planar_servo/base/core/threads.h"

#include "planar_servo/base/core/clock.h"

namespace planar {

Repeater::Repeater(double period_s, std::function<void()> act)
    : thread_([this, period_s, act = std::move(act)] {
        SteadyClock clock;
        try {
          for (double next_s = clock.now_s(); !ending_;) {
            act();
            const double now_s = clock.now_s();
            next_s = std::max(next_s + period_s, now_s);
            clock.sleep_for_s(next_s - now_s);
          }
        } catch (...) {
          fault_ = std::current_exception();
          failed_ = true;
        }
      }) {}

Repeater::~Repeater() {
  ending_ = true;
  thread_.join();
}

void Repeater::require_well() const {
  if (failed_) std::rethrow_exception(fault_);
}

}  // namespace planar
