#pragma once

#include <ctime>
#include <string>

namespace planar {

/// A clock that counts seconds from an arbitrary start. A virtual cell has a clock of its own, on
/// which waiting takes no real time.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual double now_s() const = 0;
  virtual void sleep_for_s(double duration_s) = 0;
};

/// The computer's monotonic clock.
class SteadyClock final : public Clock {
 public:
  double now_s() const override;
  void sleep_for_s(double duration_s) override;
};

/// Returns the present time as our files have it, such as "2026-11-22T08:17:53Z".
std::string utc_now();
/// Returns a time in the same form.
std::string utc_text(std::time_t time);

}  // namespace planar
