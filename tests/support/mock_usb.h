#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "support/usb_function.h"

namespace planar::test {

/// What is wrong with the next control transfers.
struct UsbFault {
  enum class Kind { kStall, kIoError, kSilence, kShort, kLate };
  Kind kind{Kind::kStall};
  int count{1};                           ///< transfers that suffer it; -1: all, until cleared
  std::optional<std::uint8_t> request{};  ///< only this request; any when empty
  double late_s{0.0};    ///< of kLate: the function acts at once, the host hears late
  std::size_t bytes{0};  ///< of kShort: what still arrives
};

/// A USB bus below libusb, made by umockdev: whatever is plugged into it, unmodified programs find,
/// open and talk to through the real libusb. They must run with umockdev's library preloaded
/// (umockdev-wrapper), this process as well if it is to see the bus itself. One at a time.
class MockUsbBus {
 public:
  MockUsbBus();
  ~MockUsbBus();
  MockUsbBus(const MockUsbBus&) = delete;
  MockUsbBus& operator=(const MockUsbBus&) = delete;

  /// False unless this process itself runs under umockdev-wrapper.
  bool seen_by_this_process() const;

 private:
  friend class MockUsbDevice;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// One device of the bus, plugged in from the start. Safe to use from any thread.
class MockUsbDevice {
 public:
  /// Bus and function must outlive the device. Throws std::runtime_error when umockdev refuses it.
  MockUsbDevice(MockUsbBus& bus, UsbDescription description, UsbFunction& function);
  ~MockUsbDevice();
  MockUsbDevice(const MockUsbDevice&) = delete;
  MockUsbDevice& operator=(const MockUsbDevice&) = delete;

  /// As when the cable is pulled: pending transfers fail, the device leaves the bus.
  void unplug();
  /// Plugs it in again, at a new address.
  void plug();

  void inject(const UsbFault& fault);
  void clear_fault();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar::test
