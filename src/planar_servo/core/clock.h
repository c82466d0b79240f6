#pragma once

namespace planar {

/// Time in seconds from an arbitrary start. The virtual cell has a clock of its own, so that a
/// settling time costs it nothing.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual double now_s() const = 0;
  virtual void sleep_for_s(double duration_s) = 0;
};

class SteadyClock final : public Clock {
 public:
  double now_s() const override;
  void sleep_for_s(double duration_s) override;
};

}  // namespace planar
