#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "support/usb_function.h"

namespace planar::test {

/// Says what is wrong with the next control transfers.
struct UsbFault {
  /// Says what becomes of a transfer.
  enum class Kind { kStall, kIoError, kSilence, kShort, kLate };
  Kind kind{Kind::kStall};
  int count{1};  ///< number of transfers that suffer it; -1 for all until cleared
  std::optional<std::uint8_t> request{};  ///< only this request suffers it; any when empty
  double late_s{0.0};    ///< kLate: the function acts at once, the host hears of it this much later
  std::size_t bytes{0};  ///< kShort: number of bytes that still arrive
};

/// A USB bus below libusb, made by umockdev. Unmodified programs find, open and talk to whatever is
/// plugged into it through the real libusb. They must run with umockdev's library preloaded
/// (umockdev-wrapper), and so must this process if it is to see the bus itself. Only one bus may
/// exist at a time.
class MockUsbBus {
 public:
  MockUsbBus();
  ~MockUsbBus();
  MockUsbBus(const MockUsbBus&) = delete;
  MockUsbBus& operator=(const MockUsbBus&) = delete;

  /// Returns false unless this process itself runs under umockdev-wrapper.
  bool seen_by_this_process() const;

 private:
  friend class MockUsbDevice;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A device of the bus, plugged in from the start. Safe to use from any thread.
class MockUsbDevice {
 public:
  /// Takes bus and function, which must outlive the device. Throws std::runtime_error when umockdev
  /// refuses it.
  MockUsbDevice(MockUsbBus& bus, UsbDescription description, UsbFunction& function);
  ~MockUsbDevice();
  MockUsbDevice(const MockUsbDevice&) = delete;
  MockUsbDevice& operator=(const MockUsbDevice&) = delete;

  /// Pulls the cable: pending transfers fail and the device leaves the bus.
  void unplug();
  /// Plugs it in again, at a new address.
  void plug();

  /// Makes the next transfers suffer a fault.
  void inject(const UsbFault& fault);
  void clear_fault();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar::test
