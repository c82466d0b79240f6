#include "planar_servo/base/core/clock.h"

#include <fmt/chrono.h>

#include <chrono>
#include <thread>

namespace planar {

double SteadyClock::now_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void SteadyClock::sleep_for_s(double duration_s) {
  std::this_thread::sleep_for(std::chrono::duration<double>(duration_s));
}

std::string utc_now() {
  return utc_text(std::time(nullptr));
}

std::string utc_text(std::time_t time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(time));
}

}  // namespace planar
