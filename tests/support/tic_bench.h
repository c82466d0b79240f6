#pragma once

#include <array>
#include <string>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/hardware/drives/tic_drives.h"
#include "support/emulated_tic.h"
#include "support/mock_usb.h"

namespace planar::test {

/// Three Tics on a bus below libusb, with limit switches at both ends of their travel.
struct TicBench {
  /// The default timeout is long enough that a busy machine does not starve a drive.
  explicit TicBench(double command_timeout_s = 2.0) {
    for (std::size_t i = 0; i < 3; ++i) settings[i] = {kSerials[i], command_timeout_s};
    for (EmulatedTic& tic : tics) {
      tic.place_switches(kReverseSwitch_pulses, kForwardSwitch_pulses);
      tic.set_homing_speeds(20000.0, 500.0);
    }
  }

  static constexpr std::int32_t kReverseSwitch_pulses = -1000;
  static constexpr std::int32_t kForwardSwitch_pulses = 4000;
  static inline const std::array<std::string, 3> kSerials{"00411111", "00422222", "00433333"};
  static constexpr DriveLimits kLimits{2000.0, 20000.0};

  SteadyClock clock;
  std::array<EmulatedTic, 3> tics{EmulatedTic(clock), EmulatedTic(clock), EmulatedTic(clock)};
  MockUsbBus bus;
  std::array<MockUsbDevice, 3> devices{
      MockUsbDevice(bus, EmulatedTic::description(kSerials[0]), tics[0]),
      MockUsbDevice(bus, EmulatedTic::description(kSerials[1]), tics[1]),
      MockUsbDevice(bus, EmulatedTic::description(kSerials[2]), tics[2])};
  std::array<TicSettings, 3> settings;
};

}  // namespace planar::test
