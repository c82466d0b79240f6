#pragma once

#include <mutex>
#include <optional>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "support/mock_usb.h"

namespace planar::test {

/// Stands between the bus and a Tic and notes when its motor is commanded.
class WireTap final : public UsbFunction {
 public:
  explicit WireTap(UsbFunction& function) : function_(function) {}

  UsbOutcome control(const UsbSetup& setup, std::uint8_t* data) override {
    if (moves_motor(setup)) {
      const std::lock_guard lock(mutex_);
      commands_s_.push_back(clock_.now_s());
      sent_somewhere_ = setup.request == kSetTargetPosition;
    }
    return function_.control(setup, data);
  }

  /// When the motor was sent somewhere or stopped, on the steady clock.
  std::vector<double> commands_s() {
    const std::lock_guard lock(mutex_);
    return commands_s_;
  }

  /// When it was sent somewhere, unless it was told something else since.
  std::optional<double> sent_s() {
    const std::lock_guard lock(mutex_);
    return sent_somewhere_ ? std::optional(commands_s_.back()) : std::nullopt;
  }

 private:
  static constexpr int kSetTargetPosition = 0xe0, kSetTargetVelocity = 0xe3, kHaltAndHold = 0x89,
                       kHaltAndSetPosition = 0xec;

  static bool moves_motor(const UsbSetup& setup) {
    return !setup.to_host() &&
           (setup.request == kSetTargetPosition || setup.request == kSetTargetVelocity ||
            setup.request == kHaltAndHold || setup.request == kHaltAndSetPosition);
  }

  UsbFunction& function_;
  SteadyClock clock_;
  std::mutex mutex_;
  std::vector<double> commands_s_;
  bool sent_somewhere_{false};
};

}  // namespace planar::test
