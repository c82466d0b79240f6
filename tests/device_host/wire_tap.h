#pragma once

#include <mutex>
#include <vector>

#include "core/clock.h"
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
    }
    return function_.control(setup, data);
  }

  /// When the motor was sent somewhere or stopped, on the steady clock.
  std::vector<double> commands_s() {
    const std::lock_guard lock(mutex_);
    return commands_s_;
  }

 private:
  /// Set target position or velocity, halt and hold, halt and set position.
  static bool moves_motor(const UsbSetup& setup) {
    return !setup.to_host() && (setup.request == 0xe0 || setup.request == 0xe3 ||
                                setup.request == 0x89 || setup.request == 0xec);
  }

  UsbFunction& function_;
  SteadyClock clock_;
  std::mutex mutex_;
  std::vector<double> commands_s_;
};

}  // namespace planar::test
